#! id: py_uniform_star_random
#! kind: static; tags: python
#! n: 2000
ego = new Object at 0 @ 0
l = Uniform([1, 2], [3, 4, 5])
param a = Uniform(*l)
