#! id: functions_of_all_kinds
#! kind: static
#! tags: defaults, keywords, closures, recursion
#! n: 100
def outer(scale):
    def inner(v, *rest, shift=1):
        return v * scale + shift + sum(rest)
    return inner
def fact(n):
    return 1 if n < 2 else n * fact(n - 1)
double = outer(2)
ego = new Object at double(Range(1, 2)) @ double(1, 2, 3, shift=4)
param f = fact(5), g = (lambda a, b=3: a * b)(2)
