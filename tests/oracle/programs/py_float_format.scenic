#! id: py_float_format
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
x = 3.14159
param a = f'{x:.2f}', b = f'{x!s}', c = f'{x = }', d = '%s' % x, e = '{:.1f}'.format(x), g = f'{x:8.3f}|', h = f"{'nested' + str(1)}", i = '%r' % 'a', j = '%x' % 255, k = '%e' % 12345.678, l = '%g' % 0.0001, m = '%+d' % 5, n = '%05d' % 42, o = '%-6s|' % 'ab', p = '%c' % 'z', q = '%5.1f%%' % 12.345
