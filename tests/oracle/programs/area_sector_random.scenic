#! id: area_sector_random
#! kind: static
#! tags: regions, sector random
#! n: 600
h = Range(0,3)
ego = new Object in SectorRegion(0@0, 5, h, 40 deg), with requireVisible False, with allowCollisions True
param h = h
