#! id: interrupts_three_deep; kind: dynamic
#! tags: behavior:try-interrupt, nested
#! steps: 20; sims: 1; drift: 1; timestep: 1
behavior L(w, n):
    for i in range(n):
        take f'{w}{i}'
behavior B():
    try:
        try:
            do L('m', 12)
        interrupt when self.position.y in (2, 5):
            try:
                do L('i', 3)
            interrupt when self.position.y == 3:
                do L('ii', 2)
        interrupt when self.position.y == 9:
            take 'nine'
    interrupt when self.position.y == 5:
        do L('o', 2)
    interrupt when self.position.y == 13:
        abort
    take 'end'
ego = new Object with behavior B()
