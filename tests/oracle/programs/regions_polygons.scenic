#! id: regions_polygons
#! kind: static
#! tags: polygons and polylines
#! n: 500
ego = new Object in PolygonalRegion([0 @ 0, 12 @ 0, 6 @ 15])
b = new Object on PolylineRegion([20 @ 0, 30 @ 0, 30 @ 20]), with requireVisible False
c = new Object on PointSetRegion('dots', [(-10, 0), (-20, 5), (-30, 10)])
