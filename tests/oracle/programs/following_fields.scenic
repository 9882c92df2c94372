#! id: following_fields
#! kind: static
#! tags: following a field
#! n: 100
wind = VectorField('wind', lambda p: 0.05 * p.x)
ego = new Object at 1 @ 1
a = new Object following wind from 5 @ 5 for 10
b = new Object following wind for Range(20, 30)
param p = follow wind from 2 @ 0 for 6
