#! id: weights_drawn_while_running
#! kind: dynamic
#! steps: 6; sims: 400; drift: 1; timestep: 1
behavior A():
    take "a"
behavior B():
    take "b"
behavior Mix():
    while True:
        do choose {A(): 1, B(): 3}
        do shuffle A(), B()
ego = new Object at 0 @ 0, with behavior Mix()
