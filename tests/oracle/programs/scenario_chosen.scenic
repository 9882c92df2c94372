#! id: scenario_chosen; kind: dynamic
#! tags: scenario:do-choose, precondition
#! steps: 4; sims: 250; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario P(w):
    setup:
        override ego with behavior L(w)
        terminate after 2 steps
scenario Q(w):
    precondition: ego.position.y > 1
    setup:
        override ego with behavior L(w)
        terminate after 1 steps
scenario Main():
    setup:
        ego = new Object with behavior L('a')
    compose:
        do choose P('p'), Q('q')
        do choose {P('pp'): 1, Q('qq'): 3}
