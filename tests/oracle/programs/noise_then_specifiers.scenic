#! id: noise_then_specifiers
#! kind: static
#! tags: mutate, specifiers relative to a noisy object
#! n: 500
import math
ego = new Object at 0 @ 0
k = new Object at (5 @ 5)
mutate k by math.sqrt(0.25)
c = new Object left of k by 2
d = new Object at k.position offset by 0 @ 4
