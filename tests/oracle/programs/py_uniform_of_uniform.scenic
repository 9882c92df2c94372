#! id: py_uniform_of_uniform
#! kind: static; tags: python
#! n: 2000
ego = new Object at 0 @ 0
a = Uniform(1, 2)
b = Uniform(a, a + 10, Uniform(100, 200))
param b = b
