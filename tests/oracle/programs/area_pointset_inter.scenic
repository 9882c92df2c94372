#! id: area_pointset_inter
#! kind: static
#! tags: regions, pointset inter
#! n: 600
r = PointSetRegion("p", [(1,2),(3,4),(5,9)]).intersect(CircularRegion(0@0, 6))
ego = new Object in r, with requireVisible False, with allowCollisions True
