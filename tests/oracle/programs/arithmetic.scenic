#! id: arithmetic
#! kind: static
#! tags: operators on draws
#! n: 400
a = Range(1, 4)
b = Range(-3, 3)
ego = new Object at a @ b
param total = a + b, product = a * b, quotient = b / a, remainder = a % 2, negative = -b
param bigger = max(a, b), smaller = min(a, b, 0), size = abs(b), rounded = round(b), length = hypot(a, b)
param wave = sin(a) + cos(b)
