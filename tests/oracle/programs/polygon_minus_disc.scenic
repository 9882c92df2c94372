#! id: polygon_minus_disc
#! kind: static
#! n: 900
land = PolygonalRegion([0 @ 0, 20 @ 0, 20 @ 10, 10 @ 16, 0 @ 10])
pond = CircularRegion(10 @ 6, 4)
ego = new Object in land.difference(pond), with requireVisible False, with width 0.2, with length 0.2
b = new Object in land.intersect(pond), with requireVisible False, with allowCollisions True, with width 0.2, with length 0.2
require (distance from ego to b) > 3
