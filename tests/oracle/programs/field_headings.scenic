#! id: field_headings
#! kind: static
#! tags: vector fields
#! n: 300
swirl = VectorField('swirl', lambda p: p.x * 0.1)
ego = new Object at Range(1, 9) @ 0, facing swirl
b = new Object at 15 @ 15, facing 20 deg relative to swirl
param there = swirl at 12 @ 3
