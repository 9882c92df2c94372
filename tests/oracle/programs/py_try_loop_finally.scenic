#! id: py_try_loop_finally
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
n = 0
for i in range(5):
    try:
        if i == 1: continue
        if i == 3: break
    finally:
        n += 10
param n = n
