#! id: noise_everywhere
#! kind: static
#! n: 900
ego = new Object at 0 @ 0, with requireVisible False, with headingStdDev 20 deg
b = new Object at 8 @ 0, facing 90 deg, with requireVisible False
mutate
c = new Object ahead of b by 3, with requireVisible False
require b.x > 7.5
