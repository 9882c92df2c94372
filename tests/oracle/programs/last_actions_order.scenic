#! id: last_actions_order; kind: dynamic
#! tags: state:lastActions
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior A(o):
    while True:
        take 'a' if len(o.lastActions) == 0 else o.lastActions[0] + 'a'
b = new Object at 3 @ 3
behavior B2():
    take 'x'
    take 'y'
    take 'z'
    while True:
        wait
c = new Object at 6 @ 6, with behavior B2()
ego = new Object with behavior A(c)
d = new Object at 9 @ 9, with behavior A(c)
