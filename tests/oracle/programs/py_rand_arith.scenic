#! id: py_rand_arith
#! kind: static; tags: python
#! n: 2000
ego = new Object at 0 @ 0
x = Range(2, 5)
param a = x + 1, b = 2 - x, c = x * x, d = x / 2, e = 10 / x, g = x ** 2, h = 2 ** x, i = -x, j = +x, k = abs(-x), l = x % 2, m = 7 % x
