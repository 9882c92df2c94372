#! id: broken_text_number
#! kind: error
#! tags: a text and a number are added
ego = new Object
param label = 'number ' + 3
