#! id: hidden_from_ego
#! kind: static
#! tags: not visible
#! n: 500
workspace = Workspace(RectangularRegion(0 @ 0, 0, 60, 60))
ego = new Object at 0 @ 0, with visibleDistance 10
a = new Object not visible, with requireVisible False
