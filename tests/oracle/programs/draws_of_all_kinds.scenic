#! id: draws_of_all_kinds
#! kind: static
#! tags: Range, Normal, TruncatedNormal, Uniform, Discrete, DiscreteRange
#! n: 500
ego = new Object at Normal(1, 2) @ TruncatedNormal(0, 3, -2, 4)
param pick = Uniform('low', 'mid', 'high')
param number = Uniform(3, 5, 8)
param weighted = Discrete({'rare': 1, 'usual': 4})
param whole = DiscreteRange(-2, 2)
param slanted = DiscreteRange(1, 3, weights=(1, 2, 5))
