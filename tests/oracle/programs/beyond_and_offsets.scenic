#! id: beyond_and_offsets
#! kind: static
#! tags: beyond, offset by, offset along
#! n: 200
ego = new Object at 2 @ 3, facing 40 deg
a = new Object beyond 10 @ 10 by 5
b = new Object beyond 10 @ -10 by Range(1, 2) @ 5 from 0 @ 0
c = new Object offset by -6 @ Range(4, 8)
d = new Object offset along 120 deg by 0 @ 12
param p = ego offset by 1 @ 1
param q = (4 @ 4) offset along 90 deg by 0 @ 3
