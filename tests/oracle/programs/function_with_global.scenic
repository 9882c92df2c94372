#! id: function_with_global; kind: dynamic
#! tags: function, global
#! steps: 4; sims: 1; drift: 1; timestep: 1
count = 0
def bump():
    global count
    count += 1
    return count
behavior M():
    while True:
        take str(bump())
ego = new Object with behavior M()
