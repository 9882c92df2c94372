"""The syntax tree: Python's own `ast` nodes, and one class for each production that Scenic adds.

Scenic adds a few forms to Python, so its tree adds a few nodes to Python's tree. A plain Python program gives the same
tree as `ast.parse`, and `ast.walk`, `ast.dump` and `ast.NodeVisitor` work on all nodes. Every node has the `lineno`,
`col_offset`, `end_lineno`, `end_col_offset` of the `.scenic` text; columns count characters. A tree is never passed to
Python's `compile`: a program is data.

The docstring or comment of each class is its production. Annotated names are its fields. A name with a default is an
attribute, not a field, and `ast.walk` does not follow it. Read next: `syntax.parser`, which creates these.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator, Sequence
from typing import dataclass_transform


@dataclass_transform()
class _Declared(ast.AST):
    """Derives `_fields` and, for names with a default, `_attributes` of `ast` from a class's annotations."""

    def __init_subclass__(cls) -> None:
        names = inspect.get_annotations(cls)
        cls._fields = tuple(name for name in names if name not in cls.__dict__)
        cls._attributes = (*cls._attributes, *(name for name in names if name in cls.__dict__))


class Expression(_Declared, ast.expr):
    """The expressions that Scenic adds."""


class Statement(_Declared, ast.stmt):
    """The statements that Scenic adds."""


class New(Expression):
    """`[new] Class spec, spec, ...`

    `certain` is False for forms that might be an operator or a plain name (`Name at V`, `Name in R`,
    `Name offset by V`, a capitalized name alone). Such a form is an instance only if the name is a Scenic class at
    evaluation. Otherwise it means `operator`, or the plain name if `operator` is None.
    """

    cls: ast.expr
    specifiers: list[Specifier]
    certain: bool = True
    operator: ast.expr | None = None


class Specifier(Expression):
    """One of `grammar.SPECIFIERS`: `beyond X by D [from Y]` is ("beyond", [X, D, Y or None]), `with` ("with", [P, V]).

    `name` is the first words, `arguments` are the operands in the order of the text; None is an omitted operand.
    """

    name: str
    arguments: list[ast.expr | None]


class Operator(Expression):
    """A word operator: `name` is its words, `operands` are its operands; None is an omitted operand.

    `grammar.MEASURES` lists operators before a value; their operands are in the order of the letters. For example,
    `distance to Y [from X]` is ("distance", [X or None, Y]), and `relative heading of H [from X]` is ("relative heading
    of", [H, X or None]). The other operators before a value are `visible R`, `not visible R`, `follow F from V for D`,
    `initial scenario`, and the temporal `always P`, `eventually P`, `next P`.
    `grammar.INFIX` lists operators between values: `X relative to Y` is ("relative to", [X, Y]), `X deg` is ("deg",
    [X]), `X offset along H by Y` is ("offset along", [X, H, Y]). However, `X @ Y` is Python's BinOp with MatMult.
    """

    name: str
    operands: list[ast.expr | None]


class Model(Statement):  # model a.b.c
    name: str


class Param(Statement):  # param n = e, 'quoted name' = e
    names: list[str]
    values: list[ast.expr]
    places: Sequence[ast.expr] = ()  # the places of the names


class Require(Statement):  # require[p] condition [as name]; p is a number from 0 to 1
    condition: ast.expr
    probability: ast.expr | None
    name: str | None


class RequireMonitor(Statement):  # require monitor M(args)
    call: ast.expr


class Mutate(Statement):  # mutate [a, b] [by scale]; no targets: every object
    targets: list[ast.expr]
    scale: ast.expr | None


class Record(Statement):  # record [initial | final] e [every n steps] [after m steps] [as name] [to file]
    value: ast.expr
    when: str  # "each", "initial" or "final"
    name: str | None
    every: ast.expr | None
    every_unit: str | None  # "seconds" or "steps", as every unit
    delay: ast.expr | None
    delay_unit: str | None
    file: ast.expr | None


class Simulator(Statement):  # simulator e
    value: ast.expr


class TerminateWhen(Statement):  # terminate [simulation] when condition [as name]
    condition: ast.expr
    scope: str  # "scenario" or "simulation"
    name: str | None


class TerminateAfter(Statement):  # terminate after n seconds | steps
    duration: ast.expr
    unit: str


class PropertyDefault(Statement):  # property[attributes]: default, in a class body
    name: str
    attributes: list[str]
    value: ast.expr


class Behavior(Statement):
    """`behavior B(args):` or `monitor M[(args)]:`; the body excludes the guards and the docstring.

    `kind` is "behavior" or "monitor"; `started` is True for `monitor M:` without brackets, which starts in Scenic 2.
    """

    name: str
    args: ast.arguments
    preconditions: list[ast.expr]
    invariants: list[ast.expr]
    body: list[ast.stmt]
    kind: str
    docstring: str | None
    started: bool = False


class Scenario(Statement):  # scenario S(args): with setup: and compose: blocks; a body without blocks is the setup
    name: str
    args: ast.arguments
    preconditions: list[ast.expr]
    invariants: list[ast.expr]
    setup: list[ast.stmt]
    compose: list[ast.stmt]
    docstring: str | None

    @property
    def acts(self) -> bool:
        """Return whether the scenario has a compose block, preconditions or invariants."""
        return bool(self.compose or self.preconditions or self.invariants)


class TryInterrupt(Statement):  # try: ... interrupt when c: ...
    body: list[ast.stmt]
    interrupts: list[Interrupt]


class Interrupt(Statement):  # interrupt when condition:
    condition: ast.expr
    body: list[ast.stmt]


class Take(Statement):  # take a, b
    actions: list[ast.expr]


class Wait(Statement):  # wait, wait for n seconds | steps, wait until c
    duration: ast.expr | None
    unit: str | None
    until: ast.expr | None


class Do(Statement):  # do B(), C() [for n seconds | steps] [until c], do choose ..., do shuffle ...
    calls: list[ast.expr]
    how: str  # "all", "choose" or "shuffle"
    weights: list[ast.expr] | None  # one per call, or None
    duration: ast.expr | None
    unit: str | None
    until: ast.expr | None


class Abort(Statement):  # abort, in an interrupt handler
    pass


class Terminate(Statement):  # terminate, terminate simulation
    scope: str  # "scenario" or "simulation"


class Override(Statement):  # override obj spec, ...
    target: ast.expr
    specifiers: list[Specifier]


TEMPORAL = frozenset({"always", "eventually", "next", "until", "implies"})


def is_temporal(node: ast.AST) -> bool:
    """Return whether an expression contains a temporal operator."""
    return any(isinstance(part, Operator) and part.name in TEMPORAL for part in ast.walk(node))


INNER_SCOPES = (ast.FunctionDef, ast.ClassDef, ast.Lambda)
SUSPENDING = (Take, Wait, Do, Terminate)  # statements during which time may pass


def walk_own(*trees: ast.AST, scopes: tuple[type[ast.AST], ...] = INNER_SCOPES) -> Iterator[ast.AST]:
    """Yield all nodes of some trees, except nodes inside the functions and classes that the trees define."""
    pending = list(trees)
    while pending:
        node = pending.pop()
        yield node
        if not isinstance(node, scopes):
            pending.extend(ast.iter_child_nodes(node))


def suspends(*trees: ast.AST) -> bool:
    """Return whether time may pass during some statements."""
    return any(isinstance(node, SUSPENDING) for node in walk_own(*trees))
