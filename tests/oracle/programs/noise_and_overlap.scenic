#! id: noise_and_overlap
#! kind: static
#! tags: mutate, pairs of fixed objects
#! n: 500
ego = new Object at 0 @ 0
a = new Object at 2 @ 0
mutate ego, a by 0.5
