#! id: regions_rectangles
#! kind: static
#! tags: in, on rectangles, turned ones
#! n: 500
field = RectangularRegion(5 @ 5, 30 deg, 20, 10)
ego = new Object in field
b = new Object on RectangularRegion(-20 @ 0, 0, Range(4, 6), 8)
