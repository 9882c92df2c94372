#! id: require_names
#! kind: static
#! tags: requirements keep the values of names
#! n: 400
limit = 3
x = Range(0, 10)
ego = new Object at x @ 0
require x > limit
limit = 9
