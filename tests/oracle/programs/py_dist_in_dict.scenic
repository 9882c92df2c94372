#! id: py_dist_in_dict
#! kind: static; tags: python
#! n: 2000
ego = new Object at 0 @ 0
d = {'speed': Range(1, 2), 'n': {'m': Uniform(3, 4)}}
o = new Object at d['speed'] @ 20, with foo d['n']['m']
param s = d['speed'] - o.position.x, f = o.foo
