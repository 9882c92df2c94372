#! id: broken_break
#! kind: error
#! tags: break outside a loop
ego = new Object
break
