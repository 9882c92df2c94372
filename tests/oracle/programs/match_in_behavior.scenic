#! id: match_in_behavior; kind: dynamic
#! tags: behavior:match
#! steps: 5; sims: 1; drift: 1; timestep: 1
behavior M(k):
    match k:
        case 1:
            take 'one'
            take 'uno'
        case (a, b):
            take f'{a}{b}'
        case _:
            take 'other'
    take 'end'
ego = new Object with behavior M(1)
new Object at 5 @ 5, with behavior M((4, 5))
new Object at 9 @ 9, with behavior M('z')
