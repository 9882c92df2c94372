#! id: soft_two_with_hard
#! kind: static
#! tags: soft and hard requirements together
#! n: 1500
x = Range(0, 1)
y = Range(0, 1)
ego = new Object at x @ y
require[0.3] x > 0.5
require[0.8] y > x
require x + y < 1.5
