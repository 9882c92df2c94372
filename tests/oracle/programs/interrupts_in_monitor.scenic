#! id: interrupts_in_monitor; kind: dynamic
#! tags: monitor:try-interrupt
#! steps: 12; sims: 1; drift: 1; timestep: 1
behavior L(w):
    while True:
        take w
monitor M():
    try:
        while True:
            wait
    interrupt when ego.position.y == 3:
        for i in range(3):
            wait
        terminate
ego = new Object with behavior L('x')
require monitor M()
