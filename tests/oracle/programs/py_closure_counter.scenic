#! id: py_closure_counter
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
def make():
    state = {'n': 0}
    def inc():
        state['n'] += 1
        return state['n']
    return inc
i = make(); j = make()
i(); i(); j()
param a = i(), b = j()
