#! id: compose_with_loops; kind: dynamic
#! tags: scenario:compose
#! steps: 10; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
scenario P(i):
    setup:
        override ego with behavior L(f'p{i}')
        terminate after i steps
scenario Main():
    setup:
        ego = new Object with behavior L('a')
        n = 3
    compose:
        for i in range(1, n + 1):
            do P(i)
            if i == 2:
                wait
        while ego.position.y < 9:
            wait
