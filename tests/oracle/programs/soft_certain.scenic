#! id: soft_certain
#! kind: static
#! tags: probabilities 0 and 1
#! n: 400
x = Range(0, 1)
ego = new Object at x @ 0
require[0] x > 2
require[1] x > 0.5
