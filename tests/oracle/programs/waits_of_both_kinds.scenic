#! id: waits_of_both_kinds
#! kind: dynamic
#! steps: 9; sims: 1; drift: 1; timestep: 1
behavior Patient():
    take "start"
    wait for 2 steps
    take "middle"
    wait until self.position.y >= 6
    take "end"
ego = new Object at 0 @ 0, with behavior Patient()
