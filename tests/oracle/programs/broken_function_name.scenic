#! id: broken_function_name
#! kind: error
#! tags: misspelt function
ego = new Object at Rnge(0, 1) @ 0
