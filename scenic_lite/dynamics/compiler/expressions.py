"""Expressions: the evaluator's, extended to choices and to lists of the match; program functions are inlined.

This module only implements operations on values with several options, and on lists whose length depends on the match.
The evaluator handles all other operations. Read next: `dynamics.compiler.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import partial
from typing import Any

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Behavior, BehaviorCall, Bound, Builtin, Function, RandomChoice, choose, describe_kind
from scenic_lite.dynamics.compiler import choices
from scenic_lite.dynamics.compiler.code import Assembler, Label
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, InlinedBody
from scenic_lite.dynamics.compiler.emit import is_whole, register_of
from scenic_lite.dynamics.compiler.lists import FUNCTIONS, comprehension, element_at, over_lengths, refused
from scenic_lite.dynamics.compiler.registers import materialize
from scenic_lite.dynamics.compiler.types import RegisterList, varies
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.access import item_of
from scenic_lite.evaluation.builtins import text_of
from scenic_lite.evaluation.calls import Return, call, check_signature
from scenic_lite.evaluation.expressions import apply_sign, membership, related
from scenic_lite.language.scenic_operators import OPERATORS
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value, apply, as_number, kind_of
from scenic_lite.values.operations import ADD, LESS


def for_undecided(c: Compilation, function: Callable[..., Value], at: int, arguments: tuple, keywords: dict) -> Value:
    """Apply a function of the evaluator to the actual option of a choice, or to a list of its actual length."""
    before, value, after = arguments[:at], arguments[at], arguments[at + 1 :]
    over = over_lengths if isinstance(value, RegisterList) else choices.over_options
    return over(c, value, lambda option: function(*before, option, *after, **keywords))


def unary(c: Compilation, scope: Scope, node: ast.UnaryOp) -> Value:
    value = scope.value(node.operand)
    return choices.opposite(choices.truth(value)) if isinstance(node.op, ast.Not) else apply_sign(scope, node.op, value)


# ------------------------------------------------------------ elements
def subscript(c: Compilation, scope: Scope, node: ast.Subscript) -> Value:
    return item(c, scope, scope.value(node.value), scope.value(node.slice))


def item(c: Compilation, scope: Scope, container: Value, index: Value) -> Value:
    """Return `container[index]`; a match without such an element faults."""
    if isinstance(container, RandomChoice):
        return choices.over_options(c, container, lambda option: item(c, scope, option, index))
    if isinstance(index, RandomChoice):
        return choices.over_options(c, index, lambda option: item(c, scope, container, option))
    ends = (index.start, index.stop, index.step) if isinstance(index, slice) else (index,)
    if not isinstance(container, RegisterList) and not any(isinstance(end, RandomExpr) for end in ends):
        return item_of(scope, container, index)
    if isinstance(index, slice) and any(isinstance(end, RandomExpr) for end in ends):
        raise refused("a slice up to where the match decides", "write a filter or a loop")
    if isinstance(index, slice):
        return over_lengths(c, container, lambda items: item(c, scope, items, index))
    if isinstance(container, dict):
        raise refused("an element of a dictionary whose key the match decides", "write if and elif")
    if not is_whole(index := as_number(index)):
        what = "a fraction" if kind_of(index) == "number" else describe_kind(index)
        raise ScenicError("type", f"the index of a list is an integer, not {what}")
    items = container if isinstance(container, RegisterList) else scope.elements(container, ast.Pass())
    if isinstance(items, list) and not items:
        raise ScenicError("value", "list index out of range")
    length = items.length if isinstance(items, RegisterList) else len(items)
    place = from_start(c.code, index, length)
    if isinstance(items, RegisterList) or all(element is items[0] for element in items):  # or all options are equal
        inside = c.code.temporaries.take()
        c.code.row(op.IS_INDEX, inside, register_of(c.code, place), register_of(c.code, length))
        c.code.fault_unless(inside, "list index out of range")
    return element_at(c.code, items, place)


def from_start(code: Assembler, index: Value, length: Value) -> Value:
    """Convert an index to an index from the start of the list; a negative index counts from the end."""
    if isinstance(index, int):
        return index if index >= 0 else materialize(code, apply(ADD, length, index))
    index = materialize(code, index)
    negative = apply(LESS, index, 0)
    return materialize(code, choose(as_number(negative), [index, apply(ADD, index, length)]))


# ------------------------------------------------------------ texts, operators, comparisons
def formatted(c: Compilation, scope: Scope, node: ast.FormattedValue) -> Value:
    """Return the text of a value in an f-string; fractions and integers have different formats."""
    value, spec = scope.value(node.value), "" if node.format_spec is None else scope.value(node.format_spec)
    if kind_of(value) == "number" and not is_whole(value):
        format(0.5, spec)  # raises ValueError for an invalid format
    return text_of(scope, value, spec)


def scenic_operator(c: Compilation, scope: Scope, node: nodes.Operator) -> Value:
    """Return the value of a Scenic operator, whose operands may be choices."""
    operation = OPERATORS.get(node.name)
    if operation is None:
        raise ScenicError("unsupported", f"`{node.name}` is not supported in a behavior")
    operands = [choices.whole_choice(operand, c) for operand in scope.operands(node.operands)]
    try:
        result = operation(scope, *operands)
    except ScenicError:
        at = next((i for i, operand in enumerate(operands) if isinstance(operand, RandomChoice)), None)
        if at is None:
            raise
        choice, before, after = operands[at], operands[:at], operands[at + 1 :]
        result = choices.over_options(c, choice, lambda option: operation(scope, *before, option, *after))
    scope.refuse_none(node.operands, operands)
    return result


def comparison(c: Compilation, scope: Scope, node: ast.Compare) -> Value:
    """Return the truth of a chain of comparisons; evaluation stops at the first false comparison."""
    sides = [materialize(c.code, scope.value(node.left))]

    def next_link(sign: ast.cmpop, operand: ast.expr) -> Value:
        sides.append(materialize(c.code, scope.value(operand)))
        return link(c, scope, node, sign, *sides[-2:])

    return choices.in_turn(
        c, True, [partial(next_link, *pair) for pair in zip(node.ops, node.comparators, strict=True)]
    )


def link(c: Compilation, scope: Scope, node: ast.Compare, sign: ast.cmpop, left: Value, right: Value) -> Value:
    """Return the truth of one comparison."""
    if isinstance(sign, ast.Is | ast.IsNot):
        same = choices.same_thing(left, right)
        return same if isinstance(sign, ast.Is) else choices.opposite(same)
    if isinstance(sign, ast.In | ast.NotIn):
        inside = membership(scope, node, left, right)
        return inside if isinstance(sign, ast.In) else choices.opposite(inside)
    return related(scope, sign, left, right)


def dictionary(handler: Callable[[Scope, Any], Value], scope: Scope, node: ast.expr) -> Value:
    """Evaluate a node; the keys of a dictionary must not depend on the match."""
    return certain(handler(scope, node))


# ------------------------------------------------------------ calls
def call_value(
    c: Compilation, scope: Scope, function: Value, arguments: list, keywords: dict[str, Value], node: ast.AST
) -> Value:
    """Call any callable value."""
    if isinstance(function, RandomChoice):
        return choices.over_options(c, function, lambda option: call_value(c, scope, option, arguments, keywords, node))
    if isinstance(function, Bound):
        refuse_method(function, arguments)
        return call_value(c, scope, function.function, [function.receiver, *arguments], keywords, node)
    if isinstance(function, Function):
        return inlined(c, scope, function, arguments, keywords, node)
    if isinstance(function, Behavior):
        bound = function.bind(arguments, keywords)
        values = {name: materialize(c.code, value) for name, value in bound.items()}
        return BehaviorCall(function, values, scope.place(node))
    if isinstance(function, Builtin):
        return call_builtin(c, scope, function, arguments, keywords, node)
    return certain(call(scope, function, arguments, keywords, node))


def call_builtin(
    c: Compilation, scope: Scope, function: Builtin, arguments: list, keywords: dict[str, Value], node: ast.AST
) -> Value:
    own = FUNCTIONS.get(function.name)
    if own is not None:
        check_signature(function, [scope, node, *arguments] if function.needs_context else arguments, keywords)
        result = own(c, scope, node, *arguments, **keywords)
        if result is not NotImplemented:
            return result
    at = next((i for i, argument in enumerate(arguments) if isinstance(argument, RandomChoice | RegisterList)), None)
    if at is None or function.name in ("Uniform", "Discrete", "print"):
        return certain(call(scope, function, arguments, keywords, node))
    before, value, after = arguments[:at], arguments[at], arguments[at + 1 :]
    over = over_lengths if isinstance(value, RegisterList) else choices.over_options
    return over(c, value, lambda option: call_value(c, scope, function, [*before, option, *after], keywords, node))


CHANGING = frozenset({"append", "extend", "remove", "pop", "clear", "reverse", "setdefault"})


def refuse_method(method: Bound, arguments: list) -> None:
    """Raise ScenicError for methods that change a container, or look up a live value in a dictionary."""
    if not isinstance(method.receiver, list | dict) or not isinstance(method.function, Builtin):
        return
    name, kind = method.function.name, "list" if isinstance(method.receiver, list) else "dictionary"
    if name in CHANGING:
        raise refused(f"{name}() of a {kind} cannot be done in a match", "a variable's list can be appended to")
    if kind == "dictionary" and any(map(undecided, arguments[:1])):
        raise refused(f"{name}() of a dictionary with what the match decides", "write if and elif")


def certain(value: Value) -> Value:
    """Return a value. Raises ScenicError for a dictionary whose keys differ between matches."""
    if isinstance(value, dict) and any(map(undecided, value)):
        raise refused("a dictionary whose keys the match decides", "write a list: [ ... ]")
    return value


def undecided(value: Value) -> bool:
    """Return whether equality with a value may depend on the match: never for a behavior or an undrawn value."""
    if isinstance(value, BehaviorCall | ThetaColumn):
        return False
    if isinstance(value, list | tuple):
        return any(map(undecided, value))
    return isinstance(value, RandomExpr | RandomChoice | RegisterList) or varies(value)


# ------------------------------------------------------------ functions of the program
def inlined(
    c: Compilation, scope: Scope, function: Function, arguments: list, keywords: dict[str, Value], node: ast.AST
) -> Value:
    """Inline a function of the program."""
    bound, before = function.bind(arguments, keywords), c.code.place
    try:
        with c.entered(function, node, scope.place(node)):
            return value_of_call(c, function, {name: materialize(c.code, value) for name, value in bound.items()})
    finally:
        c.code.place = before
        c.code.known.clear()


def value_of_call(c: Compilation, function: Function, names: dict[str, Value]) -> Value:
    """Return the value of a call; the call is compiled again while the types that it reads change, which is cheap."""
    code, path, diagnostics = c.code, c.site.path, len(c.output.diagnostics)
    rows, known, reachable = len(code.rows), dict(code.known), code.reachable
    used = code.variables.used, code.temporaries.used
    while True:
        value = result_of(scope_of(c, function, dict(names)), function)
        if not c.types.settle(path):
            return value
        del code.rows[rows:], c.output.diagnostics[diagnostics:]
        code.known, code.reachable = dict(known), reachable
        code.variables.used, code.temporaries.used = used


def scope_of(c: Compilation, function: Function, names: dict[str, Value]) -> CompiledScope:
    """Return the scope of a function at its start."""
    body = InlinedBody(c.site.path, Label())
    inner = CompiledScope(c, function.scope.source, names, function.scope, body)
    inner.assigned = function.assigned
    return inner


def result_of(inner: CompiledScope, function: Function) -> Value:
    """Compile the body of a function and return its value."""
    if isinstance(function.body, ast.expr):
        return inner.value(function.body)
    try:
        inner.run(function.body)
    except Return as result:
        return result.value
    body, code = inner.inlined, inner.compilation.code
    if body.result is None:
        return None
    if code.reachable:
        body.result.store(None)
    code.put(body.end)
    return body.result.load()


EXPRESSIONS: dict[type, Callable[[Compilation, Scope, Any], Value]] = {
    ast.UnaryOp: unary,
    ast.Subscript: subscript,
    ast.FormattedValue: formatted,
    ast.BoolOp: choices.boolean,
    ast.IfExp: choices.conditional,
    ast.Compare: comparison,
    ast.ListComp: comprehension,
    ast.GeneratorExp: comprehension,
    nodes.Operator: scenic_operator,
}
