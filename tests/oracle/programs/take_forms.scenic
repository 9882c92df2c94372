#! id: take_forms; kind: dynamic
#! tags: behavior:take
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior B():
    take ('a', 'b')
    take ['c', 'd']
    take 'e', 'f'
    take ('g',), 'h'
    take ()
    take 1, 2.5, True
    take None
    take {'a': 1}
ego = new Object with behavior B()
