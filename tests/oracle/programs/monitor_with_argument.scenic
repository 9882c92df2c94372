#! id: monitor_with_argument
#! kind: dynamic
#! steps: 8; sims: 200; drift: 1; timestep: 1
monitor Stop(limit):
    steps = 0
    while True:
        steps += 1
        if ego.position.y >= limit:
            terminate
        wait
behavior Count():
    n = 0
    while True:
        take n
        n += 2
ego = new Object at 0 @ 0, with behavior Count()
end = DiscreteRange(3, 5)
require monitor Stop(end)
record ego.position.y as y
record initial (1, 2) as pair
record final ego.position.y > 3 as high
