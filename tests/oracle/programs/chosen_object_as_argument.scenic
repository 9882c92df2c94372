#! id: chosen_object_as_argument; kind: dynamic
#! tags: distribution:sampled-once
#! steps: 2; sims: 250; drift: 1; timestep: 1
a = new Object at 5 @ 0, with nm 'a'
b = new Object at -5 @ 0, with nm 'b'
behavior M(o):
    take o.nm
    take 'right' if o.position.x > 0 else 'left'
ego = new Object with behavior M(Uniform(a, b))
