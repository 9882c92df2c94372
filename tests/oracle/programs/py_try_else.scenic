#! id: py_try_else
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
def f(v):
    try:
        r = 10 / v
    except ZeroDivisionError as err:
        return 'zero ' + str(err)
    else:
        return 'ok'
    finally:
        log.append(v)
log = []
param a = f(0), b = f(2), c = str(log)
