#! id: broken_attribute
#! kind: error
#! tags: unknown attribute of an object
ego = new Object at 3 @ 4
param c = ego.paint
