#! id: py_list_slices
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
l = list(range(10))
l[2:4] = ['a']
a = str(l)
l[::3] = [0, 0, 0]
b = str(l)
l[:0] = [7]
c = str(l)
l[1] += 5
param a = a, b = b, c = c, d = l[1], e = str(l[-3:]), f = str((1, 2, 3)[1:]), g = str(list(range(10)[2:8:2]))
