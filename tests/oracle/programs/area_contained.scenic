#! id: area_contained
#! kind: static
#! tags: regions, contained
#! n: 600
r = PolygonalRegion([0@0, 20@0, 20@20, 10@6, 0@20])
ego = new Object in r, with regionContainedIn r, with width 3, with length 2, with requireVisible False, with allowCollisions True
