#! id: handlers_interrupt_handlers; kind: dynamic
#! tags: behavior:try-interrupt
#! steps: 14; sims: 1; drift: 1; timestep: 1
behavior L(w, n):
    for i in range(n):
        take f'{w}{i}'
behavior B():
    try:
        do L('m', 8)
    interrupt when self.position.y >= 2 and self.position.y < 4:
        do L('one', 1)
    interrupt when self.position.y == 3:
        do L('two', 3)
    interrupt when self.position.y == 4:
        do L('three', 1)
    take 'end'
ego = new Object with behavior B()
