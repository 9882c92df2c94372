"""Instances: `[new] Class specifier, specifier, ...`, on one line or several.

After a class without `new` most specifiers leave no doubt (`Name on R`, `Name with P V`). `Name at V`, `Name in R` and
`Name offset by V` might also be operators; both readings are kept, and whoever knows what Name is chooses.
Read next: `parser_expressions`.
"""

from __future__ import annotations

import ast
import copy
import difflib
from typing import NamedTuple

from scenic_lite.syntax.cursor import LOAD, describe
from scenic_lite.syntax.lexer import Token
from scenic_lite.syntax.nodes import New, Operator, Specifier
from scenic_lite.syntax.operators import ALONG, AT, INFIX_WORDS, OR, PREFIX, RELATIVE, SEE, SPECIAL
from scenic_lite.syntax.strings import Strings


class Form(NamedTuple):
    """How a specifier is written: its words, whether a value follows them, and the words before further values."""

    words: tuple[str, ...]
    value: bool = True
    parts: tuple[tuple[str, bool], ...] = ()  # (word, must it stand there?)


FORMS = (
    Form(("at",)),
    Form(("in",)),
    Form(("on",)),
    Form(("contained", "in")),
    Form(("left", "of"), parts=(("by", False),)),
    Form(("right", "of"), parts=(("by", False),)),
    Form(("ahead", "of"), parts=(("by", False),)),
    Form(("behind",), parts=(("by", False),)),
    Form(("above",), parts=(("by", False),)),
    Form(("below",), parts=(("by", False),)),
    Form(("offset", "by")),
    Form(("offset", "along"), parts=(("by", True),)),
    Form(("beyond",), parts=(("by", True), ("from", False))),
    Form(("visible",), value=False, parts=(("from", False),)),
    Form(("not", "visible"), value=False, parts=(("from", False),)),
    Form(("following",), parts=(("from", False), ("for", True))),
    Form(("facing", "directly", "toward")),
    Form(("facing", "directly", "away", "from")),
    Form(("facing", "toward")),
    Form(("facing", "away", "from")),
    Form(("facing",)),
    Form(("apparently", "facing"), parts=(("from", False),)),
)
_FORMS: dict[str, list[Form]] = {}
for _form in FORMS:
    _FORMS.setdefault(_form.words[0], []).append(_form)

SPECIFIER_WORDS = frozenset(_FORMS) | {"with"}
SPECIFIER_NAMES = frozenset({" ".join(form.words) for form in FORMS} | SPECIFIER_WORDS)
LIST_OF_SPECIFIERS = (
    "specifiers are: with, at, in, on, left of, right of, ahead of, behind, beyond, offset by, offset along, facing, "
    "facing toward, facing away from, apparently facing, following, visible"
)

# `Name at V` and the like: the words, and the precedence of the operator's right side.
OPERATOR_FORMS: dict[tuple[str, ...], int] = {
    ("at",): PREFIX,
    ("in",): SEE,
    ("offset", "by"): AT,
    ("offset", "along"): RELATIVE,
    ("visible", "from"): ALONG,
    ("not", "visible", "from"): ALONG,
}
OPERATOR_WORDS = frozenset(words[0] for words in OPERATOR_FORMS)


class Instances(Strings):
    """The productions of instances."""

    specifier_indents = 0  # how many INDENT tokens the specifiers of the present statement have used up
    asks_truth = False  # the next expression is a condition: no instance begins it
    temporal = False
    in_target = False  # no instance may begin here: the object of `override`

    def conditional(self, value: ast.expr, start: Token) -> ast.expr:
        """`[if operation else expression]` after a value; defined in parser_expressions."""
        raise NotImplementedError

    def continued(self, left: ast.expr, level: int, start: Token) -> ast.expr:
        """The operators after a value; defined in parser_expressions."""
        raise NotImplementedError

    # ------------------------------------------------------------ instances

    def new_instance(self) -> ast.expr:
        """`new Class [specifiers]`."""
        start = self.advance()
        if not self.is_plain_name(self.token):
            hint = 'write "new Class at X"' if self.token.kind in ("newline", "end") else ""
            self.fail(f'expected a class name after "new", found {describe(self.token)}', hint)
        return self.instance(start, self.class_name())

    def class_name(self) -> ast.expr:
        """`Name` or `module.Name`."""
        start = self.name("a class name")
        name: ast.expr = self.at(start, ast.Name(start.text, LOAD))
        while self.token.text == "." and self.is_name(self.peek()):
            self.advance()
            name = self.at(start, ast.Attribute(name, self.advance().text, LOAD))
        return name

    def instance(self, start: Token, cls: ast.expr) -> ast.expr:
        """The specifiers after a class, if any."""
        specifiers: list[Specifier] = []
        if self.begins_specifier():
            specifiers.append(self.specifier())
            self.more_specifiers(specifiers)
        elif self.is_name(self.token) and self.token.text not in INFIX_WORDS:
            self.unknown_specifier()
        return self.at(start, New(cls, specifiers))

    def starts_instance(self) -> bool:
        """After a name: does a specifier follow that cannot be an operator?"""
        token = self.token
        if token.kind != "name" or token.text not in SPECIFIER_WORDS or self.in_target:
            return False
        if token.text == "with":
            return self.is_name(self.peek())
        form = self.form()
        return form is not None and (form.words[0] not in OPERATOR_WORDS or self.sees_visible_alone(form))

    def sees_visible_alone(self, form: Form) -> bool:
        """`visible` and `not visible` without `from` are no operators."""
        return form.words[-1] == "visible" and self.peek(len(form.words)).text != "from"

    def possible_instance(self) -> ast.expr | None:
        """`Name at V` and the like at the start of an expression: New with both readings, or None."""
        if self.in_target or self.temporal or not self.is_name(self.token):
            return None
        ahead = 1
        while self.peek(ahead).text == "." and self.peek(ahead + 1).kind == "name":
            ahead += 2
        if self.peek(ahead).text not in OPERATOR_WORDS or not self.peek(ahead - 1).text[0].isupper():
            return None
        start, index = self.token, self.index
        cls = self.class_name()
        words = next((words for words in OPERATOR_FORMS if self.sees(*words)), None)
        if words is None:
            self.go_back(index)
            return None
        return self.both_readings(start, cls, words)

    def both_readings(self, start: Token, cls: ast.expr, words: tuple[str, ...]) -> ast.expr:
        """Read what follows once, and build the instance and the operator from it."""
        place = self.token
        self.skip(len(words))
        heading = None
        if words == ("offset", "along"):
            heading = self.operation(RELATIVE)
            self.expect("by", 'after "offset along" and its heading', 'write "offset along H by V"')
        self.needs_value(" ".join(words))
        value_start = self.token
        value = self.operation(OPERATOR_FORMS[words])
        operator = self.at(start, _operator(cls, words, value, heading))
        whole = self.conditional(self.continued(value, OR, value_start), value_start)
        arguments: list[ast.expr | None] = [whole] if heading is None else [heading, whole]
        if words[-1] == "from":
            words = words[:-1]
        specifiers = [self.at(place, Specifier(" ".join(words), arguments))]
        self.check_end(None, " ".join(words))
        self.more_specifiers(specifiers)
        node = self.at(start, New(cls, specifiers))
        if len(specifiers) == 1:
            node.certain = False
            node.operator = _grafted(whole, value, operator)
        return node

    def lone_class(self, value: ast.expr, start: Token) -> ast.expr:
        """In dialect 2 a capitalised name alone, as a statement or assigned, may be an instance."""
        if self.dialect != 2 or not isinstance(value, ast.Name) or not value.id[0].isupper():
            return value
        if start.text == "(":
            return value
        node = self.at(start, New(value, []))
        node.certain = False
        return node

    # ------------------------------------------------------------ specifiers

    def more_specifiers(self, specifiers: list[Specifier]) -> None:
        """`, specifier` as often as it comes; a line may end after a comma if the next one is indented."""
        while self.token.text == ",":
            index, indents = self.index, self.specifier_indents
            comma = self.advance()
            if self.brackets == 0 and self.token.kind == "newline":
                self.next_line(comma)
            if not self.begins_specifier():
                if self.is_misspelt():
                    self.unknown_specifier()
                if self.specifier_indents or (self.brackets == 0 and not self.begins_instance()):
                    hint = 'a place is written "3 @ 4"' if self.token.kind == "number" else ""
                    self.fail(f"expected a specifier after the comma, found {describe(self.token)}", hint)
                self.specifier_indents = indents
                self.go_back(index)
                return
            specifiers.append(self.specifier())

    def next_line(self, comma: Token) -> None:
        """Go to the next line, which must be indented deeper than the statement."""
        self.advance()
        while self.token.kind in ("indent", "dedent"):
            self.specifier_indents += 1 if self.token.kind == "indent" else -1
            if self.specifier_indents <= 0:
                break
            self.advance()
        if self.specifier_indents <= 0:
            hint = "take the comma away, or indent the next specifier"
            self.fail("a comma ends the line, but no indented specifier follows", hint, at=comma)

    def begins_instance(self) -> bool:
        """After a comma outside of brackets: is it a tuple of instances?"""
        token = self.token
        return token.kind == "name" and (token.text == "new" or token.text[0].isupper())

    def is_misspelt(self) -> bool:
        """Do two words stand side by side that no expression begins with?"""
        token, following = self.token, self.peek()
        if not self.is_plain_name(token) or token.text in INFIX_WORDS:
            return False
        if self.begins_prefix():
            return False
        if following.kind in ("number", "string"):
            return True
        return self.is_plain_name(following) and following.text not in INFIX_WORDS | SPECIFIER_WORDS

    def begins_prefix(self) -> bool:
        """Does a word operator such as `distance from` come next?"""
        return self.token.text in SPECIAL

    def unknown_specifier(self) -> None:
        """Report a word that is no specifier, with the nearest one that is."""
        word = self.token.text
        self.fail(f'unknown specifier "{word}"', specifier_hint(word))

    def begins_specifier(self) -> bool:
        """Does a specifier come next?"""
        token = self.token
        if token.kind != "name" or token.text not in SPECIFIER_WORDS:
            return False
        return token.text == "with" or self.form() is not None

    def form(self) -> Form | None:
        """The form whose words come next, and after them what it needs."""
        for form in _FORMS.get(self.token.text, ()):
            if self.sees(*form.words):
                following = self.peek(len(form.words))
                if len(form.words) == 1 and form.value and following.text in (".", "=", ")", "]", "}", ",", ":"):
                    continue
                if form.words[0] == "facing" and len(form.words) > 1 and not self.starts_value(following, "([-"):
                    continue
                return form
        return None

    def specifier(self) -> Specifier:
        """One specifier."""
        start = self.token
        if start.text == "with":
            return self.with_property()
        form = self.form()
        assert form is not None
        self.skip(len(form.words))
        name = " ".join(form.words)
        arguments: list[ast.expr | None] = [self.specifier_value(name)] if form.value else []
        for word, needed in form.parts:
            if self.accept(word):
                arguments.append(self.specifier_value(f"{name} ... {word}"))
            elif needed:
                self.missing_part(name, word)
            else:
                arguments.append(None)
        node = self.at(start, Specifier(name, arguments))
        self.check_end(form, name)
        return node

    def specifier_value(self, name: str) -> ast.expr:
        """The value after the words of a specifier."""
        self.needs_value(name)
        return self.expression()

    def needs_value(self, name: str) -> None:
        """The line or argument must not end after the words of a specifier, nor a word too many follow."""
        if name == "facing" and self.token.text in ("to", "at", "towards") and self.starts_value(self.peek(), ""):
            self.fail(f'unknown specifier "facing {self.token.text}"', 'did you mean "facing toward"?')
        if self.token.kind in ("newline", "end") or self.token.text in (",", ")"):
            self.fail(f'expected a value after "{name}", found {describe(self.token)}')

    def with_property(self) -> Specifier:
        """`with property value`."""
        start = self.advance()
        word = self.name("a property name")
        if self.token.text in ("=", ":"):
            hint = f'write "with {word.text} value"'
            self.fail(f'"{self.token.text}" between a property and its value', hint)
        name = self.at(word, ast.Constant(word.text))
        value = self.specifier_value(f"with {word.text}")
        node = self.at(start, Specifier("with", [name, value]))
        self.check_end(None, f"with {word.text}")
        return node

    def missing_part(self, name: str, word: str) -> None:
        """Report a specifier that lacks a word such as `by`."""
        form = {
            "beyond": "beyond X by D [from Y]",
            "offset along": "offset along H by V",
            "following": "following F [from V] for D",
        }[name]
        self.fail(f'expected "{word}" in "{name}", found {describe(self.token)}', f'write "{form}"')

    def check_end(self, form: Form | None, name: str) -> None:
        """Diagnose the two frequent slips after a specifier: no `by` before a distance, no comma."""
        if self.token.kind == "number" and form is not None and ("by", False) in form.parts:
            self.fail(f'expected "by" before the distance of "{name}"', f'write "{name} X by {self.token.text}"')
        if self.token.kind == "name" and self.token.text in SPECIFIER_WORDS and self.begins_specifier():
            self.fail(f'expected a comma before the specifier "{self.token.text}"')


def specifier_hint(word: str) -> str:
    """The specifier that a word was perhaps meant to begin, or all there are."""
    close = difflib.get_close_matches(word, sorted(SPECIFIER_NAMES), 1, 0.7)
    if not close:
        return LIST_OF_SPECIFIERS
    whole = [" ".join(form.words) for form in _FORMS.get(close[0], ())]  # of a first word such as "ahead"
    meant = close[0] if close[0] in whole or not whole else whole[0]
    return f'did you mean "{meant}"?'


def _operator(cls: ast.expr, words: tuple[str, ...], value: ast.expr, heading: ast.expr | None) -> ast.expr:
    """What the words mean if Name is no class."""
    if words == ("in",):
        return ast.Compare(cls, [ast.In()], [value])
    operands: list[ast.expr | None] = [cls, value] if heading is None else [cls, heading, value]
    return Operator(" ".join(words), operands)


def _grafted(whole: ast.expr, old: ast.expr, new: ast.expr) -> ast.expr:
    """A copy of `whole` whose leftmost value `old` is replaced by `new`: how precedence would have grouped it."""
    spine = []
    while whole is not old:
        spine.append(whole)
        whole = _left_side(whole)
    for node in reversed(spine):
        new = _regrouped(node, new)
    return new


def _left_side(node: ast.expr) -> ast.expr:
    """The first operand of an operator between values."""
    if isinstance(node, ast.BinOp | ast.Compare):
        return node.left
    if isinstance(node, ast.IfExp):
        return node.body
    first = node.values[0] if isinstance(node, ast.BoolOp) else None
    if isinstance(node, Operator):
        first = node.operands[0]
    assert first is not None
    return first


def _regrouped(node: ast.expr, left: ast.expr) -> ast.expr:
    """A copy of an operator's node with another left side; two comparisons in a row become one chain."""
    grown = copy.copy(node)
    if isinstance(grown, ast.Compare) and isinstance(left, ast.Compare):
        grown.left = left.left
        grown.ops = left.ops + grown.ops
        grown.comparators = left.comparators + grown.comparators
    elif isinstance(grown, ast.BinOp | ast.Compare):
        grown.left = left
    elif isinstance(grown, ast.IfExp):
        grown.body = left
    elif isinstance(grown, ast.BoolOp):
        grown.values = [left, *grown.values[1:]]
    elif isinstance(grown, Operator):
        grown.operands = [left, *grown.operands[1:]]
    grown.lineno, grown.col_offset = left.lineno, left.col_offset
    return grown
