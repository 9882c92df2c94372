#! id: py_error_in_comprehension
#! kind: error; tags: python
ego = new Object at 0 @ 0
a = 1
b = [1 / v for v in (1, 0)]
