#! id: area_union_oriented
#! kind: static
#! tags: regions, union oriented
#! n: 600
f = VectorField("f", lambda p: 0.5)
g = VectorField("g", lambda p: -0.7)
r = PolygonalRegion([0@0,6@0,6@6,0@6], orientation=f).union(PolygonalRegion([3@3,10@3,10@10,3@10], orientation=g))
ego = new Object in r, with requireVisible False, with allowCollisions True
