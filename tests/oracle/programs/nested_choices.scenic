#! id: nested_choices
#! kind: static
#! n: 1200
a = Uniform(Range(0, 1), Range(5, 9), 20)
b = Discrete({Range(0, 2): 1, 7: 2})
ego = new Object at a @ b, facing 200 deg, with requireVisible False
c = new Object at Uniform(Uniform(1 @ 20, 2 @ 20), 3 @ 30), with requireVisible False
param kind = Uniform("x", Uniform("y", "z"))
