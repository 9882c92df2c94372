#! id: heights_by_loops
#! kind: static
#! n: 900
levels = []
for i in range(4):
    if i % 2 == 0:
        levels.append(Range(i, i + 1))
    else:
        levels += [10 * i]
ego = new Object at levels[0] @ levels[1], with requireVisible False
others = [new Object at (5 * n) @ -20, with requireVisible False for n in range(1, 3)]
top = levels[2] + levels[-1]
require top > 32.5
param top = top
