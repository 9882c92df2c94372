#! id: names_defined_later; kind: dynamic
#! tags: behavior:forward-reference
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior B():
    take name
    take f'{other.position.x}'
    take helper(3)
    do Later(4)
ego = new Object with behavior B()
name = 'n'
other = new Object at 7 @ 7
def helper(k):
    return f'h{k * 2}'
behavior Later(q):
    take f'later{q}'
