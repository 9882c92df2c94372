#! id: view_and_wall
#! kind: static
#! tags: requireVisible, narrow view, long object
#! n: 500
ego = new Object at 0 @ 0, with visibleDistance 8, with viewAngle 40 deg
a = new Object at Range(-10, 10) @ Range(-10, 10), facing Range(0, 90) deg, with width 12, with length 1, with allowCollisions True
