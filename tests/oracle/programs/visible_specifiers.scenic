#! id: visible_specifiers
#! kind: static
#! tags: visible, visible from, not visible
#! n: 400
ego = new Object at 0 @ 0, with visibleDistance 12, with viewAngle 120 deg
a = new Object visible
b = new Object visible from 0 @ 3, with allowCollisions True, with requireVisible False
