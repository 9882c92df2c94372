#! id: py_resample
#! kind: static; tags: python
#! n: 2000
ego = new Object at 0 @ 0
c = resample(Uniform(1, 2, 3))
a = Range(0, 1)
d = Range(a, a + 1)
e = resample(d)
n = Normal(5, 1)
o = Uniform(1 @ 2, 3 @ 4)
k = DiscreteRange(1, 3)
param c = c, d = d, e = e, n = resample(n) - n, k = resample(k) - k, g = resample(3), t = resample(TruncatedNormal(0, 1, -1, 1))
