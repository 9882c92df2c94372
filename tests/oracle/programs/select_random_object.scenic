#! id: select_random_object
#! kind: static
#! tags: attributes of a random choice of objects
#! n: 500
a = new Object at -5 @ 0, with tag 'left', with requireVisible False
b = new Object at 5 @ 0, with tag 'right', with requireVisible False
ego = new Object at 0 @ 20
chosen = Uniform(a, b)
param tag = chosen.tag, x = chosen.position.x
new Object at chosen offset by 0 @ 6
