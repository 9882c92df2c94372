"""The syntax tree: Python's own `ast` nodes, and one class for each production that Scenic adds.

Scenic is Python plus a few forms, so its tree is Python's plus a few nodes: a plain Python program gives exactly what
`ast.parse` gives, and `ast.walk`, `ast.dump` and `ast.NodeVisitor` work on everything. Every node carries `lineno`,
`col_offset`, `end_lineno`, `end_col_offset` of the `.scenic` text. Nothing here is ever handed to `compile`: a
program is data.

The docstring of a class is its production. Read next: `parser`, which makes these.
"""

from __future__ import annotations

import ast

# ---------------------------------------------------------------- expressions


class New(ast.expr):
    """`[new] Class spec, spec, ...`

    `cls`: expr, the class. `specifiers`: list of Specifier. `certain`: False for the forms that might be an operator
    or a plain name (`Name at V`, `Name in R`, `Name offset by V`, a capitalised name alone): those are an instance only
    if the name turns out to be a Scenic class.
    """

    _fields = ("cls", "specifiers")
    _attributes = (*ast.expr._attributes, "certain", "operator")
    # operator: for `Name at V`, `Name in R`, `Name offset by V` the expression it is if Name is no Scenic class; None
    # otherwise.


class Specifier(ast.expr):
    """One specifier of an instance; `name` says which, `arguments` are its operands in the order of the text.

    with P V: ("with", [Constant P, V]) · at V · in R · on R · contained in R: ("contained in", [R]) ·
    left of X [by D]: ("left of", [X, D or None]), `right of`, `ahead of`, `behind` alike · offset by V ·
    offset along H by V · beyond X by D [from Y] · visible [from P] · not visible [from P] · following F [from X] for D ·
    facing H · facing toward V · facing away from V · facing directly toward V · facing directly away from V ·
    apparently facing H [from V] · above X [by D] · below X [by D]
    """

    _fields = ("name", "arguments")


class Operator(ast.expr):
    """A Scenic operator; `name` says which, `operands` are in the order given here, None for one left out.

    X @ Y: ("@", [X, Y]) is Python's BinOp with MatMult, not this class. X deg: ("deg", [X]) ·
    distance [from X] to Y: ("distance", [X, Y]) · angle [from X] to Y: ("angle", [X, Y]) ·
    relative heading of H [from H2] · relative position of X [from Y] · apparent heading of P [from V] ·
    distance past V [of P]: ("distance past", [V, P]) · F at V: ("at", [F, V]) · X relative to Y ·
    X offset by Y · X offset along H by Y: ("offset along", [X, H, Y]) · X can see Y · X intersects Y ·
    follow F from V for D: ("follow", [F, V, D]) · visible R · not visible R · R visible from P: ("visible from", [R, P]) ·
    front of O, back of O, left of O, right of O, front left of O, ...: ("front left of", [O]) ·
    always P, eventually P, next P, P until Q, P implies Q · initial scenario: ("initial scenario", [])
    """

    _fields = ("name", "operands")


# ---------------------------------------------------------------- statements


class Model(ast.stmt):
    """`model a.b.c`; `name`: str."""

    _fields = ("name",)


class Param(ast.stmt):
    """`param n = e, 'quoted name' = e`; `names`: list of str, `values`: list of expr, `places`: list of expr (the names)."""

    _fields = ("names", "values")
    _attributes = (*ast.stmt._attributes, "places")


class Require(ast.stmt):
    """`require[p] condition [as name]`; `probability`: expr or None, `name`: str or None."""

    _fields = ("condition", "probability", "name")


class RequireMonitor(ast.stmt):
    """`require monitor M(args)`; `call`: expr."""

    _fields = ("call",)


class Mutate(ast.stmt):
    """`mutate [a, b] [by scale]`; `targets`: list of expr (empty: every object), `scale`: expr or None."""

    _fields = ("targets", "scale")


class Record(ast.stmt):
    """`record [initial | final] e [every n steps] [after m steps] [as name] [to file]`.

    `when`: "each", "initial" or "final"; `every`, `delay`, `file`: expr or None; the units: "seconds", "steps" or None.
    """

    _fields = ("value", "when", "name", "every", "every_unit", "delay", "delay_unit", "file")


class Simulator(ast.stmt):
    """`simulator e`; `value`: expr."""

    _fields = ("value",)


class TerminateWhen(ast.stmt):
    """`terminate [simulation] when condition [as name]`; `scope`: "scenario" or "simulation", `name`: str or None."""

    _fields = ("condition", "scope", "name")


class TerminateAfter(ast.stmt):
    """`terminate after n seconds | steps`; `unit`: "seconds" or "steps"."""

    _fields = ("duration", "unit")


class PropertyDefault(ast.stmt):
    """`property[attributes]: default`, in a class body; `attributes`: list of str."""

    _fields = ("name", "attributes", "value")


class Behavior(ast.stmt):
    """`behavior B(args):`, `monitor M[(args)]:`, with `precondition: c` and `invariant: c` lines taken out of the body.

    `kind`: "behavior" or "monitor"; `args`: ast.arguments; `docstring`: str or None, no longer in the body. `started`:
    True for `monitor M:` without brackets, which Scenic 2 starts by itself.
    """

    _fields = ("name", "args", "preconditions", "invariants", "body", "kind", "docstring")
    _attributes = (*ast.stmt._attributes, "started")


class Scenario(ast.stmt):
    """`scenario S(args):` with `setup:` and `compose:` blocks; a body without them is the setup."""

    _fields = ("name", "args", "preconditions", "invariants", "setup", "compose", "docstring")


class TryInterrupt(ast.stmt):
    """`try: ... interrupt when c: ... except E: ...`; `interrupts`: list of Interrupt, `handlers`: as in `ast.Try`."""

    _fields = ("body", "interrupts", "handlers", "orelse", "finalbody")


class Interrupt(ast.stmt):
    """`interrupt when condition:`"""

    _fields = ("condition", "body")


class Take(ast.stmt):
    """`take a, b`; `actions`: list of expr."""

    _fields = ("actions",)


class Wait(ast.stmt):
    """`wait`, `wait for n seconds | steps`, `wait until c`; `duration`, `unit`, `until`: None where absent."""

    _fields = ("duration", "unit", "until")


class Do(ast.stmt):
    """`do B(), C() [for n seconds | steps] [until c]`, `do choose ...`, `do shuffle ...`.

    `calls`: list of expr; `how`: "all", "choose" or "shuffle"; `weights`: list of expr or None, beside `calls`.
    """

    _fields = ("calls", "how", "weights", "duration", "unit", "until")


class Abort(ast.stmt):
    """`abort`, in an interrupt handler."""

    _fields = ()


class Terminate(ast.stmt):
    """`terminate`, `terminate simulation`; `scope`: "scenario" or "simulation"."""

    _fields = ("scope",)


class Override(ast.stmt):
    """`override obj spec, ...`; `target`: expr, `specifiers`: list of Specifier."""

    _fields = ("target", "specifiers")
