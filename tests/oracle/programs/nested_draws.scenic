#! id: nested_draws
#! kind: static
#! tags: draws inside draws
#! n: 500
low = Range(0, 2)
ego = new Object at Range(low, low + 5) @ Uniform(low, Range(10, 11), 20)
param mix = Normal(low, 0.5) + Uniform(1, 2) * DiscreteRange(0, 3)
