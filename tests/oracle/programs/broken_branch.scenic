#! id: broken_branch
#! kind: error
#! tags: random control flow in a function
def side(v):
    if v > 3:
        return 'right'
    return 'left'
ego = new Object at Range(0, 6) @ 0
param where = side(ego.position.x)
