#! id: area_polyline_methods
#! kind: static
#! tags: regions, polyline methods
#! n: 600
l = PolylineRegion([0@0,10@0,10@10])
ego = new Object at l.pointAlongBy(12), with requireVisible False, with allowCollisions True
b = new Object at l.pointAlongBy(0.25, normalized=True), with requireVisible False, with allowCollisions True
param d = l.distanceTo(5@5), s = l.signedDistanceTo(5@2), t = l.signedDistanceTo(5@-2), p = l.project(12@3)
