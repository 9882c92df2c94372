#! id: parts_record_and_override
#! kind: dynamic
#! steps: 8; sims: 1; drift: 1; timestep: 1
behavior Say(word):
    while True:
        take word
scenario Loud(word, n):
    setup:
        override ego with behavior Say(word)
        terminate after n steps
scenario Main():
    setup:
        ego = new Object at 0 @ 0, with behavior Say("hm")
        record initial ego.position.y as first
        record ego.position.y * 2 as twice
        record final ego.position.y as last
    compose:
        wait
        for i in range(2):
            do Loud(f"loud{i}", 1 + i)
            wait
