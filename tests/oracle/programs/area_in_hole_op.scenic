#! id: area_in_hole_op
#! kind: static
#! tags: regions, in hole op
#! n: 600
a = RectangularRegion(0@0,0,12,12).difference(RectangularRegion(0@0,0,0.5,0.5))
ego = new Object in a, with width 3, with length 3, with requireVisible False, with allowCollisions True
require ego in a
