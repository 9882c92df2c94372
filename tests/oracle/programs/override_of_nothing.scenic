#! id: override_of_nothing
#! kind: dynamic
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior Say(word):
    while True:
        take word
scenario Voice(who, word):
    setup:
        override who with behavior Say(word)
        terminate after 3 steps
scenario Main():
    setup:
        ego = new Object at 0 @ 0
    compose:
        wait
        do Voice(ego, "x")
        wait
