#! id: area_choice_three
#! kind: static
#! tags: regions, choice three
#! n: 600
a = CircularRegion(0@0,2)
b = PolygonalRegion([10@0,12@0,12@5])
c = SectorRegion(-20@0,5,0,1)
r = Discrete({a: 1, b: 2, c: 1})
ego = new Object in r, with requireVisible False, with allowCollisions True
