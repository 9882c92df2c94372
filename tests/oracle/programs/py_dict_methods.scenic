#! id: py_dict_methods
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
d = {'a': 1}
d.update({'b': 2}); d.update(c=3)
x = d.setdefault('z', 26)
p = d.pop('a'); q = d.pop('nope', 0)
d['b'] += 10
e = {**d, 'k': 1}
param a = str(d), x = x, p = p, q = q, g = d.get('b'), h = d.get('no', 5), n = d.get('no'), k = str(list(d.keys())), v = str(list(d.values())), i = str(list(d.items())), l = len(e), c = 'b' in d, m = str(dict(x=1, y=2)), o = str(dict([('a', 1)])), r = str(sorted(d)), s = str(dict.fromkeys(['a', 'b'], 0)), t = str({'a': 1} == {'a': 1})
