#! id: py_text_methods
#! kind: static; tags: python
#! n: 2
ego = new Object at 0 @ 0
s = 'Hello World'
param a = s.lower(), b = s.upper(), c = s.replace('o', '0'), d = str(s.split()), e = s.find('World'), f = s.startswith('He'), g = s.index('o'), h = s.count('l'), i = s.swapcase(), j = s.center(15, '*'), k = s.rjust(12, '.'), l = s.ljust(12, '.'), m = '7'.zfill(3), n = s.partition(' ')[2], o = str(s.rsplit('o', 1)), p = s.title(), q = 'a b'.isalnum(), r = s[::-1], t = s.endswith(('d', 'x')), u = '\n'.join(['a', 'b']), v = str('a\nb'.splitlines()), w = s.strip('Hd'), x = s.removeprefix('Hello '), y = ' x '.strip(), z = s.casefold()
