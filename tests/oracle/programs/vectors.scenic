#! id: vectors
#! kind: static
#! tags: arithmetic of vectors
#! n: 300
v = Range(1, 2) @ Range(3, 4)
ego = new Object at v + (1 @ 1)
new Object at v * 5 - (2 @ 0), with requireVisible False
param twice = 2 * v, halved = v / 2, across = v.x, along = v.y, turned = v.rotatedBy(90 deg)
w = 3 @ 4
param far = w.distanceTo(0 @ 0), towards = w.angleTo(10 @ 10), size = w.norm()
