#! id: eventually_in_always; kind: dynamic
#! tags: temporal
#! steps: 4; sims: 200; drift: 1; timestep: 1
behavior C():
    while True:
        take 'c'
ego = new Object at 0 @ Range(0, 10), with behavior C()
require always (ego.position.y < 9 or eventually ego.position.y > 11)
