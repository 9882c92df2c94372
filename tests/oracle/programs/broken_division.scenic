#! id: broken_division
#! kind: error
#! tags: division by zero
ego = new Object
param ratio = 10 / (ego.width - 1)
