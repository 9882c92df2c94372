#! id: behaviors_nested_deep
#! kind: dynamic
#! steps: 10; sims: 1; drift: 1; timestep: 1
behavior Inner(k):
    invariant: self.position.y < 100
    for i in range(k):
        take f"in{i}"
behavior Middle(k):
    try:
        do Inner(k)
        do Inner(1) until self.position.y > 20
    interrupt when self.position.y in (2, 3):
        take "cut"
behavior Outer():
    do Middle(3) for 6 steps
    take "mid", "way"
    do Inner(2)
ego = new Object at 0 @ 0, with behavior Outer()
