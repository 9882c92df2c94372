#! id: words
#! kind: static
#! tags: texts, f-strings, formatting
#! n: 200
k = DiscreteRange(1, 3)
ego = new Object at k @ 0
param label = str(k) + 'k', fixed = f'{3:02d}-{"a"}', joined = ','.join(['x', 'y']), upper = 'abc'.upper()
