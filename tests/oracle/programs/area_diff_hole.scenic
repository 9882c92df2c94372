#! id: area_diff_hole
#! kind: static
#! tags: regions, diff hole
#! n: 600
r = PolygonalRegion([(-5,-5),(5,-5),(5,5),(-5,5)]).difference(PolygonalRegion([(-2,-2),(2,-2),(2,2),(-2,2)]))
ego = new Object in r, with requireVisible False, with allowCollisions True
param inside = r.containsPoint(0@0), outside = r.containsPoint(3@3), edge = r.containsPoint(2@0), corner = r.containsPoint(5@5)
