#! id: py_star_args
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
def f(a, b=2, *rest, c, d=5, **kw):
    return a + 10*b + 100*len(rest) + 1000*c + 10000*d + 100000*len(kw)
args = (1, 2, 3)
param x = f(*args, c=4), y = f(1, c=1, z=3, w=4), z = f(*[1], **{'c': 2, 'd': 3})
