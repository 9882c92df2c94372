#! id: return_from_handler; kind: dynamic
#! tags: behavior:try-interrupt, return
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior S():
    try:
        while True:
            take 'a'
    interrupt when self.position.y == 4:
        return
behavior B():
    do S()
    take 'end'
ego = new Object with behavior B()
