#! id: break_from_handler; kind: dynamic
#! tags: behavior:try-interrupt, break
#! steps: 10; sims: 1; drift: 1; timestep: 1
behavior B():
    for i in range(4):
        try:
            take f'a{i}'
            take f'b{i}'
        interrupt when self.position.y == 3:
            break
    take 'end'
ego = new Object with behavior B()
