#! id: abort_in_loop; kind: dynamic
#! tags: behavior:abort
#! steps: 12; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
behavior B():
    while True:
        try:
            do L('m')
        interrupt when self.position.y % 3 == 2:
            take 'h'
            if self.position.y > 6:
                abort
    take 'end'
ego = new Object with behavior B()
