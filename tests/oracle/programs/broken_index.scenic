#! id: broken_index
#! kind: error
#! tags: index out of range
spots = [1, 2, 3]
ego = new Object at spots[3] @ 0
