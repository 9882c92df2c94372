#! id: broken_object_at_run_time; kind: error
#! tags: behavior:new
#! run: dynamic; steps: 5
def mk():
    return new Object at 5 @ 5
behavior B():
    take 'a'
    o = mk()
    take 'b'
ego = new Object with behavior B()
