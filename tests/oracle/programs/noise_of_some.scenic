#! id: noise_of_some
#! kind: static
#! n: 900
ego = new Object at 0 @ 0, with requireVisible False
cone = new Object at 6 @ Range(-1, 1), with positionStdDev (0.5, 2, 0), with requireVisible False
post = new Object ahead of cone by 4, with requireVisible False
mutate cone, post by 0.5
require cone.x > 5.5
