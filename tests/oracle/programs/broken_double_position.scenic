#! id: broken_double_position
#! kind: error
#! tags: two specifiers of a position
ego = new Object at 0 @ 0
b = new Object at 3 @ 4, offset by 4 @ 4
