#! id: random_list_read_in_behavior; kind: dynamic
#! tags: distribution:sampled-once
#! steps: 3; sims: 250; drift: 1; timestep: 1
xs = [Range(0, 1), Range(0, 1), Uniform(3, 4)]
behavior M():
    take 'hi' if xs[0] > xs[1] else 'lo'
    take str(xs[2])
    s = 0
    for x in xs:
        s += 1 if x > 0.5 else 0
    take str(s)
ego = new Object with behavior M()
