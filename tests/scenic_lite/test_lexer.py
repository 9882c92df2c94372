"""Tokens: agreement with Python's own tokenizer, places, and what is refused."""

import heapq
import io
import tokenize

import pytest

from scenic_lite.errors import ScenicError
from scenic_lite.syntax.lexer import MAX_CHARACTERS, Source, lex

KINDS = {
    tokenize.NAME: "name",
    tokenize.NUMBER: "number",
    tokenize.STRING: "string",
    tokenize.OP: "operator",
    tokenize.NEWLINE: "newline",
    tokenize.INDENT: "indent",
    tokenize.DEDENT: "dedent",
    tokenize.ENDMARKER: "end",
}


def tokens(text):
    return lex(Source(text, "<program>"))


def ours(text):
    return [(t.kind, t.text if t.kind not in ("newline", "indent") else "", t.line, t.column) for t in tokens(text)]


def pythons(text):
    found = tokenize.generate_tokens(io.StringIO(text).readline)
    kept = [t for t in found if t.type not in (tokenize.COMMENT, tokenize.NL)]
    return [(KINDS[t.type], t.string if KINDS[t.type] not in ("newline", "indent") else "", *t.start) for t in kept]


@pytest.mark.parametrize(
    "text",
    [
        "x = 1\n",
        "if x:\n    y\n\n  # a comment\n    z\nelse:\n\tw\n",
        "f(a,\n  b)  # c\n",
        "x = '''a\nb''' + r\"\\d\" + rb'x'\n",
        "x = 1_000 + 0xFF + 1.5e-3 + .5 + 5. + 0o17 + 0b1\n",
        "a = b \\\n  + c\n",
        "x **= y // z >> w != v ... -> :=\n",
        "é = ñ\n",
        "while x:\n  if y:\n    z\nw\n",
        "\n\n# only comments\n",
        "x = 90 deg @ -3\n",
        "class A:\n    def f(self):\n        pass\n\n    x = 1\n",
    ],
)
def test_tokens_are_those_of_python(text):
    assert ours(text) == pythons(text)


def test_tokens_of_a_whole_module_are_those_of_python():
    with open(heapq.__file__, encoding="utf-8") as file:
        text = file.read()
    assert ours(text) == pythons(text)


def test_line_ends_and_marks_of_other_systems():
    assert [t.text for t in tokens("\ufeffa\r\nb\rc")] == ["a", "\n", "b", "\n", "c", "", ""]


def test_missing_last_line_end():
    assert [t.kind for t in tokens("if x:\n  y")] == [
        *("name", "name", "operator", "newline", "indent", "name", "newline", "dedent", "end")
    ]


def test_columns_count_characters():
    assert [(t.text, t.column) for t in tokens("'é' + x")][2] == ("x", 6)


REFUSED = [
    ("x = (1,\ny = [2]\n", 1, 5, '"(" is never closed'),
    ("x = (1]\n", 1, 7, '"]" does not match the "(" of line 1'),
    ("x = 1)\n", 1, 6, '")" closes no bracket'),
    ("x = 'abc\n", 1, 5, "the string is not closed in its line"),
    ('x = 1\ny = """abc\n', 2, 5, 'the string that """ opens is never closed'),
    ("if x:\n\ty\n        z\n", 3, 1, "tabs and spaces are mixed in the indentation"),
    ("if x:\n    y\n  z\n", 3, 1, "the indentation fits no block above"),
    ("x = 3\0\n", 1, 6, "the program contains a null byte"),
    ("x = “a”\n", 1, 5, 'the character "“" is not part of the language'),
    ("x = 3 – 4\n", 1, 7, 'the character "–" is not part of the language'),
    ("x = \x07\n", 1, 5, "the character U+0007 is not part of the language"),
    ("x = $y\n", 1, 5, 'the character "$" is not part of the language'),
    ("x = 4foo\n", 1, 5, '"4foo" is neither a number nor a name'),
    ("x = 0777\n", 1, 5, "a whole number does not begin with 0"),
    ("x = \\ y\n", 1, 5, "a backslash may only end a line"),
]


@pytest.mark.parametrize(("text", "line", "column", "message"), REFUSED)
def test_refused_with_place(text, line, column, message):
    with pytest.raises(ScenicError) as caught:
        tokens(text)
    error = caught.value
    assert (error.kind, error.line, error.column, error.message) == ("syntax", line, column, message)


@pytest.mark.parametrize(
    "text",
    [
        "x = 1\n" * (MAX_CHARACTERS // 6 + 1),
        "(" * 10_000,
        "".join(" " * depth + "if x:\n" for depth in range(500)),
    ],
    ids=["length", "brackets", "blocks"],
)
def test_absurd_sizes_are_a_budget_error(text):
    with pytest.raises(ScenicError) as caught:
        tokens(text)
    assert caught.value.kind == "budget"
