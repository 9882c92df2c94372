#! id: py_percent_format
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
param a = '%d and %s' % (3, 'x'), b = '%.2f' % 3.14159, c = '%5d|%-5d|' % (4, 5), d = '%(k)s!' % {'k': 'v'}, e = '100%%' % ()
