#! id: regions_round
#! kind: static
#! tags: circles and sectors
#! n: 500
ego = new Object in CircularRegion(3 @ 4, 6)
b = new Object in SectorRegion(20 @ 0, 10, 45 deg, 60 deg), with allowCollisions True
param inside = (2 @ 3) in CircularRegion(3 @ 4, 2)
