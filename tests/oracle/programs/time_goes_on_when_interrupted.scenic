#! id: time_goes_on_when_interrupted; kind: dynamic
#! tags: behavior:do-for
#! steps: 14; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
behavior B():
    try:
        do L('a') for 4 steps
        take 'body end'
    interrupt when self.position.y == 2:
        do L('h') for 4 steps
    take 'end'
ego = new Object with behavior B()
