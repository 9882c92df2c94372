#! id: area_offset_along_field
#! kind: static
#! tags: regions, offset along field
#! n: 600
f = VectorField("f", lambda p: p.x * 0.1)
ego = new Object at 5@1, with requireVisible False, with allowCollisions True
b = new Object offset along f by 1@4, with requireVisible False, with allowCollisions True
c = new Object at (2@3 offset along f by 0@2), with requireVisible False, with allowCollisions True
