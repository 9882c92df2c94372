#! id: py_raise_uncaught
#! kind: error; tags: python
ego = new Object at 0 @ 0
x = 3
raise ValueError("mine")
