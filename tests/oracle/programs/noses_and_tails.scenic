#! id: noses_and_tails
#! kind: static
#! n: 900
ego = new Object at 2 @ 3, facing Range(-30, 30) deg, with length 4, with width 2
a = new Object ahead of (front of ego) by 2, with requireVisible False
b = new Object left of (back right of ego) by 1 @ 2, with allowCollisions True, with requireVisible False
c = new OrientedPoint behind ego by 3, facing 15 deg relative to ego.heading
param tail = c.position, turn = relative heading of c from ego
