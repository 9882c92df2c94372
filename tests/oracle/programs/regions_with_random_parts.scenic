#! id: regions_with_random_parts
#! kind: static
#! n: 900
size = Range(2, 6)
yard = RectangularRegion(Range(-3, 3) @ 0, 20 deg, size, 8)
disc = CircularRegion(0 @ 12, size)
ego = new Object in yard, with requireVisible False
b = new Object in disc, with requireVisible False
c = new Object in SectorRegion(0 @ -30, 9, 45 deg, Range(40, 80) deg), with requireVisible False
