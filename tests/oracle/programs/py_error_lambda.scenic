#! id: py_error_lambda
#! kind: error; tags: python
ego = new Object at 0 @ 0
f = lambda v: v.foo
x = 3
y = f(x)
