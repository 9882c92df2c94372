#! id: handlers_with_draws
#! kind: dynamic
#! steps: 8; sims: 400; drift: 1; timestep: 1
import random
side = Uniform("left", "right")
behavior Go(limit):
    try:
        do Walk() for 3 steps
        take "done"
    interrupt when self.position.y >= limit:
        take side
        if self.position.y > limit + 1:
            abort
behavior Walk():
    while True:
        take Uniform("a", "b", "b", "b")
ego = new Object at 0 @ 0, with behavior Go(DiscreteRange(1, 3))
