#! id: area_inter_circle_rect
#! kind: static
#! tags: regions, inter circle rect
#! n: 600
r = CircularRegion(0@0,5).intersect(RectangularRegion(5@0,0,10,10))
ego = new Object in r, with requireVisible False, with allowCollisions True
