#! id: area_diff_two
#! kind: static
#! tags: regions, diff two
#! n: 600
r = RectangularRegion(0@0,0,10,10).difference(RectangularRegion(0@0,0,2,20)).difference(RectangularRegion(0@0,0,20,2))
ego = new Object in r, with requireVisible False, with allowCollisions True
