#! id: scenario_for_and_until; kind: dynamic
#! tags: scenario:do-for, do-until, wait
#! steps: 12; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario P(w):
    setup:
        override ego with behavior L(w)
scenario Main():
    setup:
        ego = new Object with behavior L('a')
    compose:
        do P('p'), P('q') for 2 steps
        do P('r') until ego.position.y > 4
        do P('s') for 3 seconds
        wait for 2 steps
        wait until ego.position.y >= 11
