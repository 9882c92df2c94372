#! id: interrupt_without_action; kind: dynamic
#! tags: behavior:try-interrupt, handler without an action
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
behavior B():
    n = 0
    try:
        while True:
            take f'm{n}'
    interrupt when self.position.y == 2 and n == 0:
        n = 1
    interrupt when self.position.y == 4 and n == 1:
        n = 2
        take 'four'
    take 'x'
ego = new Object with behavior B()
