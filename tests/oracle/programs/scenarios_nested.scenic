#! id: scenarios_nested; kind: dynamic
#! tags: scenario:nested
#! steps: 12; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario Leaf(w, n):
    setup:
        override ego with behavior L(w)
        terminate after n steps
scenario Mid(w):
    compose:
        do Leaf(w + '1', 1)
        do Leaf(w + '2', 2)
scenario Main():
    setup:
        ego = new Object with behavior L('a')
    compose:
        do Mid('x')
        do Mid('y')
