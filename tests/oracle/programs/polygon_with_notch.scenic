#! id: polygon_with_notch
#! kind: static
#! tags: concave polygon
#! n: 600
ego = new Object in PolygonalRegion([0 @ 0, 10 @ 0, 10 @ 10, 5 @ 3, 0 @ 10])
