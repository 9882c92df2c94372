#! id: py_nested_try
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
out = []
for i in range(4):
    try:
        try:
            if i == 0: [][0]
            if i == 1: {}['q']
            if i == 2: int('z')
        except IndexError:
            out.append('I')
        else:
            out.append('-')
        finally:
            out.append('F')
    except (KeyError, ValueError) as e:
        out.append(type(e).__name__)
param o = ' '.join(out)
