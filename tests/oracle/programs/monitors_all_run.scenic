#! id: monitors_all_run; kind: dynamic
#! tags: monitor:terminate, rejection
#! steps: 6; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
monitor M():
    wait
    terminate
monitor N():
    wait
    require False
ego = new Object with behavior L('x')
require monitor M()
require monitor N()
