#! id: uniform_over_lists
#! kind: static
#! tags: unpacked options, resample of choices
#! n: 500
options = [1, 2, 5]
x = Uniform(*options)
y = resample(x)
ego = new Object at x @ y
param z = Uniform(x, 10)
