#! id: cut_normals
#! kind: static
#! n: 900
a = TruncatedNormal(10, 3, 8, 20)
b = TruncatedNormal(Range(-1, 1), 0.5, -1, 1)
ego = new Object at a @ b, facing TruncatedNormal(0, 1, -0.5, 2)
param again = resample(a)
