#! id: require_in_behavior; kind: dynamic
#! tags: behavior:require, rejection
#! steps: 5; sims: 200; drift: 1; timestep: 1
behavior C():
    while True:
        take 'c'
        require self.position.y < 10
ego = new Object at 0 @ Range(0, 10), with behavior C()
