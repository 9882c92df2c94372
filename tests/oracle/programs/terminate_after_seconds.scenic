#! id: terminate_after_seconds; kind: dynamic
#! tags: terminate-after
#! steps: 10; sims: 1; drift: 1; timestep: 0.5
behavior C():
    while True:
        take 'c'
ego = new Object with behavior C()
terminate after 2 seconds
