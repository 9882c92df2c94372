#! id: scenarios_in_parallel; kind: dynamic
#! tags: scenario:parallel, override
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario P(o, w, n):
    setup:
        override o with behavior L(w)
        terminate after n steps
scenario Main():
    setup:
        ego = new Object with behavior L('a')
        other = new Object at 5 @ 5, with behavior L('b')
    compose:
        do P(ego, 'x', 2), P(other, 'y', 4)
        wait
        do P(ego, 'z', 2)
