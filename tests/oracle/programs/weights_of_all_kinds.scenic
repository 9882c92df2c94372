#! id: weights_of_all_kinds
#! kind: static
#! n: 900
coin = Discrete({"heads": 3, "tails": 1})
die = DiscreteRange(1, 4, weights=(1, 2, 3, 4))
spot = Discrete({(0 @ 5): 2, (3 @ 9): 1, (7 @ 7): 0})
ego = new Object at spot
param coin = coin, die = die
param mix = die * DiscreteRange(0, 2)
