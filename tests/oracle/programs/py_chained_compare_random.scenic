#! id: py_chained_compare_random
#! kind: error; tags: python
ego = new Object at 0 @ 0
x = Range(0, 1)
if 0 < x < 1:
    y = 2
