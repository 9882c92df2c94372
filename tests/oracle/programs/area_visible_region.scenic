#! id: area_visible_region
#! kind: static
#! tags: regions, visible region
#! n: 600
ego = new Object at 2@3, facing 0.5, with visibleDistance 8, with viewAngle 60 deg, with requireVisible False, with allowCollisions True
b = new Object in visible RectangularRegion(0@5,0,20,8), with requireVisible False, with allowCollisions True
c = new Object in not visible RectangularRegion(0@5,0,20,8), with requireVisible False, with allowCollisions True
