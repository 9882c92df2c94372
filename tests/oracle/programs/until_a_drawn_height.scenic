#! id: until_a_drawn_height; kind: dynamic
#! tags: behavior:do-until, draw at run time
#! steps: 6; sims: 250; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
behavior B():
    do L('a') until self.position.y > Range(0, 4)
    take 'end'
ego = new Object with behavior B()
