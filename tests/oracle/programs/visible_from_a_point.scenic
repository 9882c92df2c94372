#! id: visible_from_a_point
#! kind: static
#! tags: visible from
#! n: 500
ego = new Object at 0 @ 0
v = new OrientedPoint at 30 @ 0, facing 90 deg, with viewAngle 90 deg, with visibleDistance 10
a = new Object visible from v, with width 3, with length 3
