#! id: area_poly_in
#! kind: static
#! tags: regions, poly in
#! n: 600
p = PolygonalRegion([0@0, 10@0, 10@10, 5@3, 0@10])
ego = new Object in p, with requireVisible False, with allowCollisions True
