#! id: broken_invisible
#! kind: error
#! tags: a fixed object that the ego cannot see
ego = new Object at 0 @ 0, with visibleDistance 5
b = new Object at 30 @ 0
