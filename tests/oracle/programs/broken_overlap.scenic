#! id: broken_overlap
#! kind: error
#! tags: two fixed objects overlap
ego = new Object at 0 @ 0
b = new Object at 0.5 @ 0
