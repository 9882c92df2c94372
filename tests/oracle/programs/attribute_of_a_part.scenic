#! id: attribute_of_a_part
#! kind: dynamic
#! steps: 8; sims: 1; drift: 1; timestep: 1
scenario Mark(x):
    setup:
        level = x * 2
        who = new Object at x @ 4
        terminate after 2 steps
scenario Main():
    setup:
        ego = new Object at 0 @ 0
    compose:
        first = Mark(5)
        do first
        require first.who.position.x > 4 and first.level == 10
        wait
        do Mark(9) for 1 steps
