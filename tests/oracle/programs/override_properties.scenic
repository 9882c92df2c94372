#! id: override_properties; kind: dynamic
#! tags: scenario:override
#! steps: 6; sims: 1; drift: 1; timestep: 1
behavior L():
    while True:
        take f'{self.foo} {self.bar}'
scenario P():
    setup:
        override ego with foo 5, with bar 'b2'
        terminate after 2 steps
scenario Main():
    setup:
        ego = new Object with behavior L(), with foo 1, with bar 'b1'
    compose:
        wait
        do P()
        wait
