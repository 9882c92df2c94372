#! id: scenario_makes_objects; kind: dynamic
#! tags: scenario:setup
#! steps: 6; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario P(w):
    setup:
        c = new Object at 10 @ 10, with behavior L(w)
        terminate after 2 steps
scenario Main():
    setup:
        ego = new Object with behavior L('a')
    compose:
        do P('p')
        wait
