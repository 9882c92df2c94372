#! id: broken_param_twice
#! kind: error
#! tags: a parameter twice in a statement
ego = new Object
param a = 1, b = 2, a = 3
