#! id: views_and_walls
#! kind: static
#! n: 900
workspace = Workspace(RectangularRegion(0 @ 0, 0, 30, 30))
ego = new Object at -5 @ 0, facing -90 deg, with viewAngle 80 deg, with visibleDistance 14
seen = new Object visible, with width 0.1, with length 0.1, with allowCollisions True
unseen = new Object not visible, with requireVisible False, with allowCollisions True, with width 0.1, with length 0.1
