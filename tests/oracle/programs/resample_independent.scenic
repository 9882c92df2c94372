#! id: resample_independent
#! kind: static
#! tags: resample and independent instances
#! n: 400
x = Range(0, 10)
y = resample(x)
ego = new Object at x @ y
param gap = x - y
