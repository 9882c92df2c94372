#! id: broken_return
#! kind: error
#! tags: return outside a function
ego = new Object
return 3
