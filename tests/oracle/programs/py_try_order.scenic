#! id: py_try_order
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
def kind(i):
    try:
        if i == 0: [][1]
        if i == 1: {}['k']
        if i == 2: int('x')
        if i == 3: undefined_name
        if i == 4: (3).foo
        if i == 5: 'a' + 1
        if i == 6: assert i == 0, 'no'
        if i == 7: raise RuntimeError('rt')
    except IndexError: return 'index'
    except KeyError: return 'key'
    except LookupError: return 'lookup'
    except ValueError: return 'value'
    except NameError: return 'name'
    except AttributeError: return 'attribute'
    except TypeError: return 'type'
    except AssertionError as e: return 'assert ' + str(e)
    except Exception as e: return 'other ' + str(e)
param k = ' '.join([kind(i) for i in range(8)])
