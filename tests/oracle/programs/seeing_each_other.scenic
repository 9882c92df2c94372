#! id: seeing_each_other
#! kind: static
#! tags: can see both ways
#! n: 500
ego = new Object at 0 @ 0
a = new Object at Range(-10, 10) @ 10, facing toward ego, with viewAngle 20 deg, with visibleDistance 30
b = new Object at Range(-10, 10) @ 0, with allowCollisions True
require a can see b
require b can see a
