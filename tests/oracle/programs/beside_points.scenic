#! id: beside_points
#! kind: static
#! tags: left of, right of, ahead of, behind points
#! n: 200
ego = new Object at 0 @ -20
spot = new OrientedPoint at 3 @ 4, facing 50 deg
a = new Object left of spot by 2, with width 4
b = new Object right of spot by Range(3, 5), with allowCollisions True
c = new Object ahead of spot by 9
d = new Object behind 10 @ 10 by 3, facing -45 deg
e = new Object right of 20 @ 20, facing 10 deg
