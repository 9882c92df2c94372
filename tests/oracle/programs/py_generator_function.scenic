#! id: py_generator_function
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
def evens(n):
    i = 0
    while i < n:
        yield i
        i += 2
def both():
    yield from evens(4)
    yield 100
param a = str(list(evens(7))), b = sum(both()), c = str([x + 1 for x in evens(3)])
