#! id: parts_in_parallel
#! kind: dynamic
#! steps: 10; sims: 1; drift: 1; timestep: 1
behavior Say(word):
    while True:
        take word
scenario Talk(who, word, n):
    setup:
        override who with behavior Say(word)
        terminate after n steps
scenario Main():
    setup:
        ego = new Object at 0 @ 0, with behavior Say("e")
        mate = new Object at 5 @ 0, with behavior Say("m")
    compose:
        do Talk(ego, "E", 2), Talk(mate, "M", 3)
        try:
            do Talk(mate, "again", 4)
        interrupt when ego.position.y == 5:
            wait
        wait
