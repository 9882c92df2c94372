#! id: area_field_rel
#! kind: static
#! tags: regions, field rel
#! n: 600
f = VectorField("f", lambda p: p.x * 0.1)
ego = new Object at 3@4, facing 0.2 relative to f, with requireVisible False, with allowCollisions True
b = new Object in CircularRegion(0@0,4), facing f relative to 0.2, with requireVisible False, with allowCollisions True
c = new Object at 1@1, facing f relative to ego.heading, with requireVisible False, with allowCollisions True
