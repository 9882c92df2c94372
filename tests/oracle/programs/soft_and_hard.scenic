#! id: soft_and_hard
#! kind: static
#! n: 1200
ego = new Object at Range(0, 10) @ 0, with requireVisible False
b = new Object at Range(0, 10) @ 5, with requireVisible False
require ego.x < b.x
require[0.6] b.x - ego.x > 4
require[0.3] ego.x > 5
