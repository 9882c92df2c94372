#! id: choose_deadlock; kind: dynamic
#! tags: behavior:do-choose, rejection
#! steps: 3; sims: 5; drift: 1; timestep: 1
behavior I(w):
    precondition: False
    take w
behavior S():
    take 'x'
    do choose I('a'), I('b')
ego = new Object with behavior S()
