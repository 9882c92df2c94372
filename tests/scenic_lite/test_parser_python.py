"""Pure Python must give the trees and the places of Python's own parser."""

import ast
import os
import sys
from pathlib import Path

import pytest

from scenic_lite.errors import ScenicError
from scenic_lite.syntax import nodes
from scenic_lite.syntax.parser import parse

LIBRARY = Path(os.__file__).parent
NAMES = """
abc argparse ast base64 bisect calendar cmd codecs collections/__init__ colorsys configparser contextlib copy csv
dataclasses datetime difflib dis enum fractions functools getopt heapq html/parser inspect ipaddress json/decoder
keyword logging/__init__ numbers operator optparse pathlib pprint queue random selectors shlex statistics string
subprocess textwrap threading tokenize traceback types typing uuid zipfile
"""
MODULES = NAMES.split()


@pytest.mark.slow
@pytest.mark.skipif(sys.version_info >= (3, 12), reason="a newer library is written in a newer grammar")
@pytest.mark.parametrize("name", MODULES)
def test_standard_library(name):
    text = (LIBRARY / f"{name}.py").read_text(encoding="utf-8")
    reference, found = ast.parse(text), parse(text, name, 0)
    assert ast.dump(found) == ast.dump(reference)
    places = list(zip(characters(reference, text), characters(found, None), strict=True))
    assert sum(ours == pythons for ours, pythons in places) >= 0.995 * len(places)


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="a newer library is written in a newer grammar")
@pytest.mark.parametrize("name", MODULES[::6])
@pytest.mark.parametrize("dialect", [2, 3])
def test_scenic_leaves_python_alone(name, dialect):
    """Where no word of Scenic is used as a name, the same trees come out of all dialects."""
    text = (LIBRARY / f"{name}.py").read_text(encoding="utf-8")
    try:
        found = parse(text, name, dialect)
    except ScenicError as error:
        assert any(f'"{word}"' in str(error) for word in ("to", "at", "on", "of", "by", "new", "do", "until"))
        return
    assert ast.dump(PlainPython().visit(found)) == ast.dump(ast.parse(text))


class PlainPython(ast.NodeTransformer):
    """Resolves what might be an instance as if no name were a Scenic class, and properties as annotations."""

    def visit_New(self, node):
        assert not node.certain
        return self.generic_visit(node.operator or node.cls)

    def visit_PropertyDefault(self, node):
        return ast.AnnAssign(ast.Name(node.name, ast.Store()), self.visit(node.value), None, 1)


def characters(tree, text):
    """The place of each node, in characters as ours are; `text` if the columns are Python's bytes."""
    lines = text.split("\n") if text is not None else None
    for node in ast.walk(tree):
        if hasattr(node, "lineno"):
            ends = ((node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset))
            yield ends if lines is None else tuple((line, decoded(lines[line - 1], column)) for line, column in ends)


def decoded(line, column):
    return column if line.isascii() else len(line.encode()[:column].decode(errors="ignore"))


SNIPPETS = [
    "match x:\n  case [1, *rest] | (2, y) as z if z: pass\n  case {'a': b, **c}: pass\n  case A.B(x, y=-1): pass\n"
    "  case None | 'a' 'b' | 1+2j | _: pass\n  case a, b: pass\n  case (a), []: pass\n",
    "match = 3; case = match\nmatch(x)\nmatch[0] = 1\n",
    "async def f():\n  async with a as b, c: pass\n  async for x in y: await z\n  return [i async for i in j]\n",
    "try:\n  pass\nexcept* (A, B) as e: pass\n",
    "try: a\nexcept A as e: b\nexcept: c\nelse: d\nfinally: e\n",
    "with (open(a) as b, c as d,): pass\nwith (a, b): pass\nwith (a): pass\n",
    "with (yield): pass\nwith a as (b, c): pass\n",
    "def f(a, b: int, /, c=1, *d: int, e, f=2, **g) -> x: return\n",
    "lambda: 0; lambda *a, **k: (a, k); lambda x, /, y=1, *, z: x\n",
    "x = f'{a}{b!r}{c:>{w}.2f}{d=}{e = !s:^3}{{}}' 'tail' rf'\\d{f}'\n",
    "x = f''; y = f'a' 'b'; z = 'a' u'b'; w = u'a' 'b'\n",
    "x = f'''{\na +\nb}'''\n",
    "f(x for x in y); f(*a, b, *c, d=1, **e, **g); f(a, (x for x in y)); f(a := 1)\n",
    "a[1], a[1:2], a[::3], a[1:2, ...], a[:, 1], a[*b], a[b:=1]\n",
    "x = y = z, = 1,\n*a, b = c\n(x) = 1\n(x): int = 3\nx.y: int\n",
    "if (n := 10) > 5 and not m or 1 < 2 <= 3 != 4 is not 5 not in 6: pass\nelif a: b\nelif c: d\nelse: e\n",
    "for i, *j in a, *b: break\nelse: continue\n",
    "while 1: pass\nelse: pass\n",
    "del a, b[0], (c.d, e)\nglobal x, y\nassert a, b\nraise A from b\nraise\n",
    "from . import a\nfrom ..b.c import (d as e, f,)\nimport a.b as c, d\nfrom a import *\n",
    "@a.b(c)\n@d\nclass E(F, *g, metaclass=H, **i):\n  'doc'\n  x: int = 1\n",
    "{}; {1: 2, **a, 3: 4,}; {1, *b}; {i: j for i, j in k if l if m}; {i for i in j}; [*a, b]; (a,); ()\n",
    "-x ** -y ** z; not -a; ~b; a @ b @ c; a if b else c if d else e; a | b ^ c & d << e >> f\n",
    "x = 0xFF, 0o17, 0b101, 1_000.5e-3, 2.5J, 10 ** 400, 1e400, 00\n",
    "x = '\\n\\t\\x41\\u00e9\\U0001F600\\N{BULLET}\\101\\\n', b'\\xff\\0a', r'\\n', '\\''\n",
    "def g():\n  x = yield\n  y = yield a, b\n  yield from c\n  z = (yield)\n  return *a, b\n",
    "x += yield_ if a else b; y //= 1; z @= m; w **= 2; v >>= 1\n",
    "def f(): pass; x = 1;\n",
    "print(not x, -1 if y else z, *(a or b))\n",
    "a.b.c[d](e)(f).g = h\n",
    "async_ = 1; x = [i for i in range(5) for j in k if i]\n",
]


@pytest.mark.parametrize("text", SNIPPETS)
def test_productions_of_python(text):
    assert ast.dump(parse(text, "p", 0)) == ast.dump(ast.parse(text))


REFUSED = """
x = = 1
x = 1 +
f(a b)
f(a=1, b)
f(x for x in y, 1)
def f(a=1, b): pass
def f(a, a): pass
def f(*): pass
lambda: x = 1
3 = x
f() = 1
x + 1 += 2
(a, b): int
del f()
*a
x = *a
for 1 in x: pass
if x: pass else: pass
class: pass
import a.
from a import
a if b
a not b
b'é'
b'a' 'b'
'\\x4'
'\\N{no such character}'
f'{'
f'{a!x}'
f'{}'
f'}'
f'{a b}'
try: pass
while: pass
else: pass
return = 3
x = [1, 2
{1: 2, 3}
a[]
""".strip().split("\n")


@pytest.mark.parametrize("text", REFUSED)
def test_what_python_refuses(text):
    with pytest.raises(SyntaxError):
        compile(text, "p", "exec")
    for dialect in (0, 2, 3):
        with pytest.raises(ScenicError) as caught:
            parse(text, "p", dialect)
        assert caught.value.kind == "syntax" and caught.value.line == 1


def test_dialect_is_checked():
    with pytest.raises(ValueError, match="dialect must be 2 or 3"):
        parse("x", dialect=4)


def test_nodes_declare_their_fields():
    assert nodes.New._fields == ("cls", "specifiers")
    assert set(nodes.New._attributes) >= {"lineno", "end_col_offset", "certain", "operator"}
    assert nodes.Abort._fields == ()
