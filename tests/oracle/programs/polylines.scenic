#! id: polylines
#! kind: static
#! tags: on a polyline, heading along it
#! n: 500
road = PolylineRegion([0 @ 0, 20 @ 0, 20 @ 10])
ego = new Object on road, with requireVisible False
b = new Object on road, facing 10 deg relative to road.orientation, with allowCollisions True, with requireVisible False
