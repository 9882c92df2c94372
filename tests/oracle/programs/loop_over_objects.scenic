#! id: loop_over_objects; kind: dynamic
#! tags: simulation:objects, loop
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior B():
    for o in simulation().objects:
        if o is self:
            take 'me'
        else:
            take f'{o.position.x:.0f}'
    others = [o for o in simulation().objects if o is not self]
    best = min(others, key=lambda q: distance from self to q)
    take f'{best.position.x}'
    near = None
    for o in others:
        if near is None or (distance from self to o) < (distance from self to near):
            near = o
    take f'{near.position.x}'
    take str(len(others))
ego = new Object with behavior B()
new Object at 5 @ 0
new Object at 3 @ 0
new Object at -9 @ 0
