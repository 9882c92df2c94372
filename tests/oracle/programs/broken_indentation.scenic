#! id: broken_indentation
#! kind: error
#! tags: indentation
ego = new Object
  b = new Object at 3 @ 3
