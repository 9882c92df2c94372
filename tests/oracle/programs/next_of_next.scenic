#! id: next_of_next; kind: dynamic
#! tags: temporal
#! steps: 4; sims: 200; drift: 1; timestep: 1
behavior C():
    while True:
        take 'c'
ego = new Object at 0 @ Range(0, 10), with behavior C()
require next (next ego.position.y > 6)
require not (next (ego.position.y > 10))
