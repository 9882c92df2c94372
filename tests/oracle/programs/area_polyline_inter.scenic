#! id: area_polyline_inter
#! kind: static
#! tags: regions, polyline inter
#! n: 600
l = PolylineRegion([-20@0,20@1]).intersect(CircularRegion(0@0,5))
ego = new Object on l, with requireVisible False, with allowCollisions True
