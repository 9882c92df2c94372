#! id: view_with_camera
#! kind: static
#! tags: cameraOffset, random ego
#! n: 500
ego = new Object at Range(-5, 5) @ 0, facing Range(0, 90) deg, with visibleDistance 8, with viewAngle 100 deg, with cameraOffset 1 @ 2
a = new Object at Range(-12, 12) @ Range(-12, 12), with allowCollisions True
