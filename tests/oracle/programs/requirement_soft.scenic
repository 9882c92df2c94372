#! id: requirement_soft
#! kind: static
#! tags: soft requirement
#! n: 1500
x = Range(0, 1)
ego = new Object at x @ 0
require[0.6] x > 0.7
