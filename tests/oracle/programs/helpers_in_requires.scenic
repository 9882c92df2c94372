#! id: helpers_in_requires
#! kind: static
#! n: 900
def apart(things, gap):
    for i, a in enumerate(things):
        for b in things[i + 1:]:
            if (distance from a to b) < gap:
                return False
    return True
things = [new Object at Range(0, 8) @ (3 * i), with allowCollisions True, with requireVisible False for i in range(3)]
ego = things[0]
require apart(things, 4)
require max([t.x for t in things]) > 5 or things[1].x < things[2].x
