#! id: discrete_range_random_ends
#! kind: static
#! tags: DiscreteRange with random ends
#! n: 500
low = Range(0, 3)
ego = new Object at DiscreteRange(low, 6) @ 0, with requireVisible False
param low = low
