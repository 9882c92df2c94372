#! id: terminate_when; kind: dynamic
#! tags: terminate-when
#! steps: 10; sims: 1; drift: 1; timestep: 1
behavior C():
    while True:
        take 'c'
ego = new Object with behavior C()
lim = 3
terminate when ego.position.y >= lim as tw
lim = 5
