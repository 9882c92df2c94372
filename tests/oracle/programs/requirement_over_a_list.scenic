#! id: requirement_over_a_list
#! kind: static
#! tags: max, min, sum of objects in requirements
#! n: 400
ego = new Object at 0 @ 0
others = []
for k in range(4):
    others.append(new Object at (k * 4 + 4) @ Range(-2, 2))
require max(o.y for o in others) > 1
require min([o.y for o in others]) < -1
require sum(o.y for o in others) > 0
