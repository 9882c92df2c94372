#! id: broken_unpacking
#! kind: error
#! tags: too many values
a, b = (1, 2, 3)
ego = new Object at a @ b
