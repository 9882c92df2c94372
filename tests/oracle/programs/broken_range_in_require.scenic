#! id: broken_range_in_require
#! kind: error
#! tags: a draw in a requirement
ego = new Object
require Range(0, 1) < 0.5
