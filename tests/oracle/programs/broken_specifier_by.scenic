#! id: broken_specifier_by
#! kind: error
#! tags: by is missing
ego = new Object
b = new Object left of ego 3
