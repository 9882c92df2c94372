"""Pure Python must give the trees and the places of Python's own parser."""

import ast
import os
import sys
import textwrap
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


WORDS = ("to", "at", "on", "of", "by", "new", "do", "until", "require")
# Python's forms that the language leaves out.
LEFT_OUT = (
    *(ast.Match, ast.Try, ast.TryStar, ast.Raise, ast.Yield, ast.YieldFrom, ast.Await, ast.With, ast.Set, ast.SetComp),
    *(
        ast.AsyncFunctionDef,
        ast.AsyncFor,
        ast.AsyncWith,
        ast.Delete,
        ast.Nonlocal,
        ast.NamedExpr,
        ast.AnnAssign,
        ast.Global,
    ),
    *(ast.BitAnd, ast.BitOr, ast.BitXor, ast.LShift, ast.RShift, ast.Invert),
)


def is_left_out(node):
    """Return whether a form of Python is refused."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mod):
        return isinstance(node.left, ast.JoinedStr) or isinstance(getattr(node.left, "value", None), str)
    if isinstance(node, ast.Constant):
        return isinstance(node.value, bytes | complex) or node.value is ...
    if isinstance(node, ast.FormattedValue):
        return node.conversion >= 0 or (node.format_spec is not None and any(map(is_field, ast.walk(node.format_spec))))
    if isinstance(node, ast.arguments):
        return bool(node.posonlyargs or node.kwonlyargs or node.kwarg)
    if isinstance(node, ast.keyword):
        return node.arg is None
    if isinstance(node, ast.Starred):
        return isinstance(node.ctx, ast.Store)
    if isinstance(node, ast.ImportFrom):
        return node.level > 0
    if isinstance(node, ast.Dict):
        return None in node.keys
    return isinstance(node, LEFT_OUT) or bool(getattr(node, "decorator_list", None))


def is_field(node):
    return isinstance(node, ast.FormattedValue)


def python_tree(text):
    """Return Python's own tree of a text, in which u"..." is a text like any other."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant):
            node.kind = None
    return tree


def parts_of(name):
    """Yield the statements of a module of Python's library, and of its classes: the text of each, and Python's tree."""
    text = (LIBRARY / f"{name}.py").read_text(encoding="utf-8")
    lines = text.split("\n")
    for whole in ast.parse(text).body:
        for node in whole.body if isinstance(whole, ast.ClassDef) else [whole]:
            first = min(each.lineno for each in (node, *getattr(node, "decorator_list", ())))
            part = textwrap.dedent("\n".join(lines[first - 1 : node.end_lineno])) + "\n"
            try:
                yield part, python_tree(part)
            except SyntaxError:  # text in it is indented less, or several statements stand in one line
                continue


@pytest.mark.slow
@pytest.mark.sample(20)
@pytest.mark.skipif(sys.version_info >= (3, 12), reason="a newer library is written in a newer grammar")
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if k % 6 else []) for k, name in enumerate(MODULES)]
)
@pytest.mark.parametrize("dialect", [2, 3])
def test_standard_library(name, dialect):
    """Python's trees come out, with their places: but for what is left out, and where a word of Scenic is a name."""
    equal = 0
    places = []
    for text, reference in parts_of(name):
        left_out = any(map(is_left_out, ast.walk(reference)))
        try:
            tree = PlainPython().visit(parse(text, name, dialect))
        except ScenicError as error:
            assert left_out or any(f'"{word}"' in str(error) for word in WORDS), str(error)
            continue
        assert not left_out, text
        assert ast.dump(tree) == ast.dump(reference)
        equal += 1
        places += zip(characters(reference, text), characters(tree, None), strict=True)
    assert equal and sum(ours == pythons for ours, pythons in places) >= 0.99 * len(places)


class PlainPython(ast.NodeTransformer):
    """Resolves what might be an instance as if no name were a Scenic class, and properties as annotations."""

    def visit_New(self, node):
        assert not node.certain
        return self.generic_visit(node.operator or node.cls)

    def visit_PropertyDefault(self, node):
        name = ast.Name(node.name, ast.Store())
        name.lineno = name.end_lineno = node.lineno
        name.col_offset, name.end_col_offset = node.col_offset, node.col_offset + len(node.name)
        return ast.copy_location(ast.AnnAssign(name, self.visit(node.value), None, 1), node)


def characters(tree, text):
    """Yield the place of each node, in characters as ours are; `text` if the columns are Python's bytes."""
    lines = text.split("\n") if text is not None else None
    for node in ast.walk(tree):
        if hasattr(node, "lineno"):
            ends = ((node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset))
            yield ends if lines is None else tuple((line, decoded(lines[line - 1], column)) for line, column in ends)


def decoded(line, column):
    return column if line.isascii() else len(line.encode()[:column].decode(errors="ignore"))


SNIPPETS = [
    "match = 3; case = match\nmatch(x)\nmatch[0] = 1\n",
    "def f(a, b: int, c=1, *d: int) -> x: return\n",
    "lambda: 0; lambda *a: a; lambda x, y=1: x\n",
    "x = f'{a}{b, 1}{c:>5.2f}{{}}{d[1:2]}' 'tail' rf'\\d{f}'\n",
    "x = f'{(lambda x: x)(1)} {a != b} {[c for c in d]:3} {\"x\"}'\n",
    "x = f''; y = f'a' 'b'; z = 'a' u'b'; w = u'a' 'b'\n",
    "f(x for x in y); f(*a, b, *c, d=1); f(a, (x for x in y))\n",
    "a[1], a[1:2], a[::3], a[1, 3], a[:]\n",
    "x = y = z, = 1,\na, b = c\n(x) = 1\n",
    "if n > 5 and not m or 1 < 2 <= 3 != 4 is not 5 not in 6: pass\nelif a: b\nelif c: d\nelse: e\n",
    "for i, j in a, *b: break\nelse: continue\n",
    "while 1: pass\nelse: pass\n",
    "assert a, b\n",
    "from b.c import (d as e, f,)\nimport a.b as c, d\nfrom a import *\n",
    "class E(F, *g, metaclass=H):\n  'doc'\n  x: int\n",
    "{}; {1: 2, 3: 4,}; {i: j for i, j in k if l if m}; [*a, b]; (a,); ()\n",
    "-x ** -y ** z; not -a; a @ b @ c; a if b else c if d else e\n",
    "x = 0xFF, 0o17, 0b101, 1_000.5e-3, 10 ** 400, 1e400, 00\n",
    "x = '\\n\\t\\x41\\u00e9\\U0001F600\\N{BULLET}\\101\\\n', r'\\n', '\\''\n",
    "x += yield_ if a else b; y //= 1; z @= m; w **= 2\n",
    "def f(): pass; x = 1;\n",
    "print(not x, -1 if y else z, *(a or b))\n",
    "a.b.c[d](e)(f).g = h\n",
    "async_ = 1; x = [i for i in range(5) for j in k if i]\n",
]


@pytest.mark.parametrize("text", SNIPPETS)
@pytest.mark.parametrize("dialect", [2, 3])
def test_productions_of_python(text, dialect):
    assert ast.dump(PlainPython().visit(parse(text, "p", dialect))) == ast.dump(python_tree(text))


REFUSALS = [
    ("match x:\n  case 1: pass", 1, 1, "`match` is not supported"),
    ("x = 1\nmatch x, y:\n  case [a, *b] if a: pass", 2, 1, "`match` is not supported"),
    ("try: f()\nexcept: pass", 2, 1, "`except` is not supported"),
    ("try: f()\nfinally: g()", 2, 1, "`finally` is not supported"),
    ("try: f()\ninterrupt when x: g()\nexcept E: h()", 3, 1, "`except` is not supported"),
    ("try: f()\ninterrupt when x: g()\nelse: h()", 3, 1, "`else` after `try` is not supported"),
    ("if x: raise E()", 1, 7, "`raise` is not supported"),
    ("def f():\n  yield 1", 2, 3, "`yield` is not supported"),
    ("x = (yield)", 1, 6, "`yield` is not supported"),
    ("async def f(): pass", 1, 1, "`async` is not supported"),
    ("x = [i async for i in j]", 1, 8, "`async` is not supported"),
    ("x = 1 + await y", 1, 9, "`await` is not supported"),
    ("with open(x) as f:\n  pass", 1, 1, "`with` blocks are not supported"),
    ("@f\ndef g(): pass", 1, 1, "decorators are not supported"),
    ("class A:\n  @staticmethod\n  def f(): pass", 2, 3, "decorators are not supported"),
    ("x = y in {1, 2}", 1, 10, "sets are not supported"),
    ("x = {1}", 1, 5, "sets are not supported"),
    ("x = {*a}", 1, 5, "sets are not supported"),
    ("x = {i for i in y}", 1, 5, "sets are not supported"),
    ("x = b'a'", 1, 5, "bytes are not supported"),
    ("x = '%d' % y", 1, 10, "`%` formats no text"),
    ("x = f'{a}' 'b' % (1, 2)", 1, 16, "`%` formats no text"),
    ("x = f'{a!r}'", 1, 7, "the {} of an f-string holds a value and a plain format"),
    ("x = f'{a:{b}}'", 1, 7, "the {} of an f-string holds a value and a plain format"),
]


@pytest.mark.parametrize("dialect", [2, 3])
@pytest.mark.parametrize(("text", "line", "column", "message"), REFUSALS)
def test_what_is_left_out_of_python(text, line, column, message, dialect):
    with pytest.raises(ScenicError) as caught:
        parse(text, "p", dialect)
    error = caught.value
    assert (error.kind, error.line, error.column, error.message) == ("unsupported", line, column, message)
    assert error.hint


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
*a
x = *a
for 1 in x: pass
if x: pass else: pass
class: pass
import a.
from a import
a if b
a not b
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
    for dialect in (2, 3):
        with pytest.raises(ScenicError) as caught:
            parse(text, "p", dialect)
        assert caught.value.kind in ("syntax", "unsupported") and caught.value.line == 1


def test_dialect_is_checked():
    with pytest.raises(ValueError, match="dialect must be 2 or 3"):
        parse("x", dialect=4)


def test_nodes_declare_their_fields():
    assert nodes.New._fields == ("cls", "specifiers")
    assert set(nodes.New._attributes) >= {"lineno", "end_col_offset", "certain", "operator"}
    assert nodes.Abort._fields == ()
