#! id: scenario_requires; kind: dynamic
#! tags: scenario:require, temporal
#! steps: 6; sims: 200; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario P(w):
    setup:
        override ego with behavior L(w)
        require eventually ego.position.y > 8
        terminate after 3 steps
scenario Main():
    setup:
        ego = new Object at 0 @ Range(0, 10), with behavior L('a')
    compose:
        do P('p')
        wait
