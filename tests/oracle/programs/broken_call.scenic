#! id: broken_call
#! kind: error
#! tags: wrong number of arguments
def gap(a, b):
    return a - b
ego = new Object at gap(3) @ 0
