#! id: py_list_methods
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
l = [3, 1, 2]
l.append(5); l.extend([7, 8]); l.insert(0, 9)
p = l.pop(); q = l.pop(0)
l.remove(1)
l.sort()
a = str(l)
l.sort(reverse=True)
b = str(l)
l.sort(key=lambda v: v % 3)
c = str(l)
l.reverse()
d = str(l)
m = l.copy(); m.clear()
param a = a, b = b, c = c, d = d, p = p, q = q, e = len(m), f = l.index(5), g = [1, 1, 2].count(1), h = str(l + [1]), i = str([1] * 3), j = [1, 2] == [1, 2], k = [1, 2] < [1, 3]
