#! id: offset_forms
#! kind: static
#! tags: relative to, offset by, offset along as operators
#! n: 100
ego = new Object at 3 @ 4, facing 90 deg
param a = (1 @ 2) relative to ego.position
param b = ego.position offset by 2 @ 0
param c = (1 @ 1) offset along ego.heading by 0 @ 3
new Object at (0 @ 9) relative to ego, facing 30 deg relative to ego.heading
new Object at ego offset by -9 @ 0
