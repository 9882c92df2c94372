#! id: invariant; kind: dynamic
#! tags: behavior:invariant, rejection
#! steps: 4; sims: 200; drift: 1; timestep: 1
behavior S():
    invariant: self.position.y < 8
    while True:
        take 'a'
ego = new Object at 0 @ Range(0,10), with behavior S()
