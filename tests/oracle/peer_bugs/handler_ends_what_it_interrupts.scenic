#! id: handler_ends_what_it_interrupts
#! kind: dynamic
#! steps: 14; sims: 1; drift: 1; timestep: 1
# right: two steps of "body", one of "handler", two more of "body", two of "after"; real Scenic never comes back to "body"
behavior Say(word):
    while True:
        take word
scenario Talk(word, n):
    setup:
        override ego with behavior Say(word)
        terminate after n steps
scenario Main():
    setup:
        ego = new Object at 0 @ 0, with behavior Say("-")
    compose:
        try:
            do Talk("body", 4)
        interrupt when ego.position.y == 2:
            do Talk("handler", 1)
        do Talk("after", 2)
