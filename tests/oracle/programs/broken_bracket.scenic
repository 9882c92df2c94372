#! id: broken_bracket
#! kind: error
#! tags: bracket never closed
ego = new Object at (3 @ 4
b = new Object at 5 @ 5
