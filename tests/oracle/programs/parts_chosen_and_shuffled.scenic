#! id: parts_chosen_and_shuffled
#! kind: dynamic
#! steps: 6; sims: 400; drift: 1; timestep: 1
behavior Say(word):
    while True:
        take word
scenario Talk(word):
    setup:
        override ego with behavior Say(word)
        terminate after 1 steps
scenario Main():
    setup:
        ego = new Object at 0 @ 0, with behavior Say("-")
    compose:
        do choose {Talk("a"): 1, Talk("b"): 3}
        do shuffle Talk("c"), Talk("d")
        wait
