#! id: area_field_branch
#! kind: static
#! tags: regions, field branch
#! n: 600
def g(p):
    if p.x > 0:
        return 0.5
    return p.y * 0.1
f = VectorField("f", g)
ego = new Object in RectangularRegion(0@0,0,10,10), facing f, with requireVisible False, with allowCollisions True
param h = f[1@1]
