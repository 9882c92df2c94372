#! id: draws_in_behaviors; kind: dynamic
#! tags: draw at run time
#! steps: 3; sims: 250; drift: 1; timestep: 1
behavior B():
    x = Range(0, 1)
    y = Uniform('p', 'q', 'r')
    take 'hi' if x > 0.3 else 'lo'
    take y
    if DiscreteRange(1, 3) == 2:
        take 'two'
    else:
        take str(Discrete({'u': 1, 'v': 3}))
ego = new Object with behavior B()
