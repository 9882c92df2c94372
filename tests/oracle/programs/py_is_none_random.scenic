#! id: py_is_none_random
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
x = Range(0, 1)
param a = x is None, b = x is not None, c = x is x
