#! id: continue_from_handler; kind: dynamic
#! tags: behavior:try-interrupt, continue
#! steps: 10; sims: 1; drift: 1; timestep: 1
behavior B():
    for i in range(4):
        try:
            take f'a{i}'
            take f'b{i}'
            take f'c{i}'
        interrupt when self.position.y == 4:
            take 'h'
            continue
    take 'end'
ego = new Object with behavior B()
