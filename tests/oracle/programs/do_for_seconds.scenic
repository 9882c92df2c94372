#! id: do_for_seconds; kind: dynamic
#! tags: behavior:do-for
#! steps: 10; sims: 1; drift: 1; timestep: 0.5
behavior L(w):
    while True:
        take w
behavior B():
    do L('a') for 2 seconds
    do L('b') for 1.2 seconds
    do L('c') for 0 steps
    take 'end'
ego = new Object with behavior B()
