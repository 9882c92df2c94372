#! id: noise_and_parameters
#! kind: static
#! tags: mutate, params keep the values without noise
#! n: 500
ego = new Object at 0 @ 0
b = new Object at 5 @ 0
mutate ego, b by 0.2
param d = distance from ego to b
param h = relative heading of b
param s = b.x
