#! id: region_operations
#! kind: static
#! tags: intersection, difference and union of regions
#! n: 500
a = RectangularRegion(0 @ 0, 0, 20, 10)
b = CircularRegion(8 @ 0, 6)
ego = new Object in a.intersect(b), with requireVisible False
c = new Object in a.difference(b), with allowCollisions True, with requireVisible False
