#! id: dictionaries_and_sets
#! kind: static
#! tags: dictionaries, sets, slices, sorting
#! n: 20
sizes = {'a': 3, 'b': 1}
names = sorted(sizes, key=lambda n: sizes[n])
tail = [1, 2, 3, 4][1:3]
ego = new Object at sizes['a'] @ tail[-1], with width sum(sizes.values())
param first = names[0], count = len({1, 1, 2}), pairs = sum([i * j for i, j in zip(tail, [2, 3])])
param reached = [n for n in enumerate(names)][1][1], text = '{}-{}'.format(1, 'x')
