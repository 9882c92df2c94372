#! id: py_decorator
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
def twice(f):
    def inner(x):
        return f(f(x))
    return inner
@twice
def inc(x):
    return x + 1
def with_arg(k):
    def deco(f):
        return lambda x: f(x) * k
    return deco
@with_arg(10)
@twice
def add2(x):
    return x + 2
param a = inc(5), b = add2(1)
