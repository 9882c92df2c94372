#! id: seeing
#! kind: static
#! tags: requireVisible, can see, view angles
#! n: 500
ego = new Object at 0 @ 0, with viewAngle 90 deg, with visibleDistance 20
b = new Object at Range(-20, 20) @ Range(5, 25)
c = new Object at 0 @ -5, with requireVisible False
require not (ego can see c)
require (angle to b) < 20 deg
