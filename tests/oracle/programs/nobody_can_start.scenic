#! id: nobody_can_start
#! kind: dynamic
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior High(y):
    precondition: self.position.y > y
    take "high"
behavior Try():
    take "first"
    do choose High(50), High(60)
ego = new Object at 0 @ 0, with behavior Try()
