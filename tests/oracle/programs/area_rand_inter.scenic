#! id: area_rand_inter
#! kind: static
#! tags: regions, rand inter
#! n: 600
x = Range(1,5)
r = CircularRegion(0@0,x).intersect(RectangularRegion(5@0,0,10,10))
ego = new Object in r, with requireVisible False, with allowCollisions True
param x = x
