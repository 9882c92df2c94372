#! id: py_try_reraise
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
out = []
def f():
    try:
        raise IndexError('i')
    except IndexError:
        out.append('in')
        raise
try:
    f()
except LookupError as e:
    out.append(str(e))
param o = ','.join(out)
