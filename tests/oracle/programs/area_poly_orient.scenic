#! id: area_poly_orient
#! kind: static
#! tags: regions, poly orient
#! n: 600
f = VectorField("f", lambda p: p.x * 0.1)
p = PolygonalRegion([0@0, 10@0, 10@10], orientation=f)
ego = new Object in p, with requireVisible False, with allowCollisions True
a = new Object on p, with requireVisible False, with allowCollisions True
b = new Object on p, facing 0.3, with requireVisible False, with allowCollisions True
