#! id: area_union_overlap
#! kind: static
#! tags: regions, union overlap
#! n: 600
r = PolygonalRegion([0@0,6@0,6@6,0@6]).union(PolygonalRegion([3@3,10@3,10@10,3@10]))
ego = new Object in r, with requireVisible False, with allowCollisions True
