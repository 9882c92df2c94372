#! id: facing_everything
#! kind: static
#! tags: facing, facing toward, facing away from
#! n: 200
ego = new Object at 0 @ 0, facing Range(-40, 40) deg
a = new Object at 10 @ 5, facing toward ego
b = new Object at -10 @ 5, facing toward 3 @ 3
c = new Object at 0 @ 12, facing 15 deg relative to ego.heading
d = new Object at 5 @ -9, facing (30 deg) relative to (-10 deg)
