#! id: py_ego_global_function
#! kind: static; tags: python
#! n: 2
def setit():
    global ego
    ego = new Object at 3 @ 3
ego = new Object at 9 @ 9
setit()
param x = ego.position.x
