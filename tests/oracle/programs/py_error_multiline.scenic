#! id: py_error_multiline
#! kind: error; tags: python
ego = new Object at 0 @ 0
x = [1,
     2,
     3 / 0]
