#! id: broken_keyword
#! kind: error
#! tags: a keyword as a name
ego = new Object
at = 3
