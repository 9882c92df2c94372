#! id: field_on_polygon
#! kind: static
#! n: 900
flow = VectorField("flow", lambda p: 30 deg if p.y > 5 else -60 deg)
strip = PolygonalRegion([0 @ 0, 6 @ 0, 6 @ 10, 0 @ 10], orientation=flow)
ego = new Object in strip, with requireVisible False
b = new Object in strip, facing 10 deg relative to flow, with requireVisible False, with allowCollisions True
c = new Object following flow from 40 @ 0 for 8, with requireVisible False
param north = flow at 1 @ 9
