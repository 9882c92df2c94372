#! id: noise_and_view
#! kind: static
#! tags: mutate, requireVisible
#! n: 500
ego = new Object at 0 @ 0
b = new Object at 40 @ 0
mutate b by 5
param v = ego.x
