#! id: variable_not_yet_set; kind: dynamic
#! tags: scenario:try-interrupt
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario P(w):
    setup:
        override ego with behavior L(w)
scenario Main():
    setup:
        ego = new Object with behavior L('a')
    compose:
        try:
            wait
            wait
            flag = True
            wait
            wait
            wait
        interrupt when flag:
            flag = False
            do P('h') for 2 steps
