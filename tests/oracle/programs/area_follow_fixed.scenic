#! id: area_follow_fixed
#! kind: static
#! tags: regions, follow fixed
#! n: 600
f = VectorField("f", lambda p: p.x * 0.1)
ego = new Object at 1@1, with requireVisible False, with allowCollisions True
b = new Object following f for 7, with requireVisible False, with allowCollisions True
c = new Object following f from 2@3 for 30, with requireVisible False, with allowCollisions True
