#! id: terminate_in_compose; kind: dynamic
#! tags: scenario:terminate
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario P(w):
    setup:
        override ego with behavior L(w)
    compose:
        wait
        wait
        terminate
scenario Main():
    setup:
        ego = new Object with behavior L('a')
    compose:
        do P('p')
        wait
        terminate
        wait
