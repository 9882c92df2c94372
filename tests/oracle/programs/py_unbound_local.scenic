#! id: py_unbound_local
#! kind: error; tags: python
ego = new Object at 0 @ 0
x = 1
def f():
    y = x
    x = 2
    return y
f()
