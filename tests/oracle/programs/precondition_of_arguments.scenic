#! id: precondition_of_arguments; kind: dynamic
#! tags: behavior:precondition
#! steps: 8; sims: 200; drift: 1; timestep: 1
behavior I(lim, hi=9):
    precondition: self.position.y < lim
    precondition: self.position.y < hi
    invariant: lim > 2
    take f'in{lim}'
behavior S():
    do I(7)
ego = new Object at 0 @ Range(0,10), with behavior S()
