#! id: beyond_and_apparent
#! kind: static
#! n: 900
ego = new Object at 0 @ 0, facing 40 deg
mark = new Object at 8 @ 4, facing Uniform(0, 90) deg, with requireVisible False
d = new Object beyond mark by Range(2, 4) from ego, with requireVisible False
e = new Object at -6 @ 6, apparently facing 20 deg from 8 @ 4, with requireVisible False
param seen = apparent heading of mark, angle = angle from mark to d
