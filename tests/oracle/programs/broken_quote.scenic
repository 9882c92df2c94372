#! id: broken_quote
#! kind: error
#! tags: text never closed
param weather = 'sunny
ego = new Object
