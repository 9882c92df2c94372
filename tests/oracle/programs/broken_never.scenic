#! id: broken_never
#! kind: error
#! tags: rejection
x = DiscreteRange(1, 5)
ego = new Object at x @ 0
require x > 5
