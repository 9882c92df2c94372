#! id: chosen_regions
#! kind: static
#! n: 1200
box = RectangularRegion(0 @ 0, 0, 4, 2)
ring = CircularRegion(20 @ 0, 3)
path = PolylineRegion([0 @ 20, 10 @ 20, 10 @ 24])
ego = new Object in Uniform(box, ring), with requireVisible False
b = new Object on path, with requireVisible False
c = new OrientedPoint on path
param p = c.position, h = c.heading
