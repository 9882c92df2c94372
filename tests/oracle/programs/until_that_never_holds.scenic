#! id: until_that_never_holds; kind: dynamic
#! tags: temporal:until
#! steps: 6; sims: 200; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
ego = new Object at 0 @ Range(0, 5), with behavior L('x')
require (ego.position.y < 3) until (ego.position.y > 4)
require not ((ego.position.y < 1) until (ego.position.y > 2.5))
