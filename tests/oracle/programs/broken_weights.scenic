#! id: broken_weights
#! kind: error
#! tags: weights of a Discrete that are none
ego = new Object at Discrete({1: 'often', 2: 3}) @ 0
