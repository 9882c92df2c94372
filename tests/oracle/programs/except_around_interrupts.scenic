#! id: except_around_interrupts; kind: dynamic
#! tags: behavior:try-interrupt, except, finally
#! steps: 10; sims: 1; drift: 1; timestep: 1
behavior B():
    try:
        take 'a'
        take 'b'
        x = [1][4]
    interrupt when self.position.y == 1:
        take 'h'
    except IndexError:
        take 'caught'
    finally:
        take 'fin'
    take 'end'
ego = new Object with behavior B()
