#! id: shuffle_by_weight; kind: dynamic
#! tags: behavior:do-shuffle
#! steps: 4; sims: 250; drift: 1; timestep: 1
behavior I(w):
    take w
behavior S():
    do shuffle {I('a'): 1, I('b'): 5, I('c'): 2}
    take 'end'
ego = new Object with behavior S()
