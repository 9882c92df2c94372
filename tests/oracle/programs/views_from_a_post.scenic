#! id: views_from_a_post
#! kind: static
#! n: 900
ego = new Object at 0 @ 0
post = new Object at 30 @ 0, facing 90 deg, with viewAngle 60 deg, with visibleDistance 12
area = RectangularRegion(25 @ 0, 0, 30, 20)
a = new Object in (area visible from post), with requireVisible False, with allowCollisions True
b = new Object in (area not visible from post), with requireVisible False, with allowCollisions True
require (distance from a to b) > 1
