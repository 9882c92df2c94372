#! id: area_oriented_point_on
#! kind: static
#! tags: regions, oriented point on
#! n: 600
f = VectorField("f", lambda p: p.x * 0.1)
road = PolygonalRegion([0@0,10@0,10@10], orientation=f)
spot = new OrientedPoint on road
ego = new Object left of spot by 0.5, with requireVisible False, with allowCollisions True
b = new Object ahead of spot by 2, with requireVisible False, with allowCollisions True
