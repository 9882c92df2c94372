#! id: py_minmax_key
#! kind: static; tags: python
#! n: 2000
ego = new Object at 0 @ 0
l = [Range(0, 1), Range(2, 3)]
param m = max(l), n = min(l)
