"""Calls: functions of the program are inlined, built-in ones of lists have a meaning of their own here.

Read next: `dynamics.compiler.functions`, `dynamics.compiler.statements`.
"""

from __future__ import annotations

import ast

from scenic_lite.core.environment import Environment
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Behavior, BehaviorCall, Bound, Builtin, Function, RandomChoice
from scenic_lite.dynamics.compiler.attributes import set_attribute
from scenic_lite.dynamics.compiler.changing import METHODS, mutated
from scenic_lite.dynamics.compiler.choices import over_options
from scenic_lite.dynamics.compiler.code import Assembler, Label
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, InlinedBody
from scenic_lite.dynamics.compiler.functions import FUNCTIONS
from scenic_lite.dynamics.compiler.lists import put_with_room
from scenic_lite.dynamics.compiler.registers import copied, pairs, registers_in, settled
from scenic_lite.dynamics.compiler.types import RegisterList, shape_of, varies
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.calls import Return, arguments_of, bind, call, seen_from
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value


def call_node(c: Compilation, scope: Scope, node: ast.Call) -> Value:
    changed = mutation(c, scope, node)
    if changed is not None:
        return changed[0]
    function = scope.value(node.func)
    return call_value(c, scope, function, *arguments_of(scope, function, node), node)


def call_value(
    c: Compilation, scope: Scope, function: Value, arguments: list, keywords: dict[str, Value], node: ast.AST
) -> Value:
    """Call whatever can be called."""
    if isinstance(function, RandomChoice):
        return over_options(c, function, lambda each: call_value(c, scope, each, arguments, keywords, node), id(node))
    if isinstance(function, Bound):
        refuse_hashing(function, arguments)
        return call_value(c, scope, function.function, [function.receiver, *arguments], keywords, node)
    if isinstance(function, Function):
        return inlined(c, scope, function, arguments, keywords, node)
    if isinstance(function, Behavior):
        bound = bind(function.name, function.node.args, function, arguments, keywords)
        values = {name: settled(c.code, value) for name, value in bound.items()}
        return BehaviorCall(function, values, scope.place(node))
    if isinstance(function, Builtin):
        own = FUNCTIONS.get(function.name)
        if own is not None:
            result = own(c, scope, node, arguments, keywords)
            if result is not NotImplemented:
                return result
        at = next((i for i, each in enumerate(arguments) if isinstance(each, RandomChoice)), None)
        if at is not None and function.name not in ("Uniform", "Discrete", "print"):
            before, after = arguments[:at], arguments[at + 1 :]
            return over_options(
                c,
                arguments[at],
                lambda each: call_value(c, scope, function, [*before, each, *after], keywords, node),
                (id(node), at),
            )
    return certain(call(scope, function, arguments, keywords, node))


def refuse_hashing(method: Bound, arguments: list) -> None:
    """Raise the error for methods of sets and dictionaries that the machine has no rows for.

    It knows the elements of a set as they are for all matches; which of those that vary are equal, a match decides.
    """
    if not isinstance(method.receiver, set | dict) or not isinstance(method.function, Builtin):
        return
    name = method.function.name
    kind = "set" if isinstance(method.receiver, set) else "dictionary"
    if name in CHANGING:
        raise ScenicError("unsupported", f"{name}() of a {kind} cannot be done in a match", hint="use a list")
    if any(map(undecided, arguments if kind == "set" else arguments[:1])):
        raise ScenicError("unsupported", f"{name}() of a {kind} with what the match decides", hint="use a list")


CHANGING = frozenset({"add", "discard", "remove", "pop", "clear", "update", "setdefault", "popitem"})


def certain(value: Value) -> Value:
    """A set or dictionary, if its elements or keys are the same in all matches. Raises ScenicError."""
    if isinstance(value, set | dict) and any(map(undecided, value)):
        kind, parts = ("set", "elements") if isinstance(value, set) else ("dictionary", "keys")
        raise ScenicError("unsupported", f"a {kind} whose {parts} the match decides", hint="write a list: [ ... ]")
    return value


def undecided(value: Value) -> bool:
    """Whether matches may disagree about what a value is equal to: never about a behavior or a point of an interval."""
    if isinstance(value, BehaviorCall | ThetaColumn):
        return False
    if isinstance(value, list | tuple | set):
        return any(map(undecided, value))
    return isinstance(value, RandomExpr | RandomChoice | RegisterList) or varies(value)


def inlined(
    c: Compilation, scope: Scope, function: Function, arguments: list, keywords: dict[str, Value], node: ast.AST
) -> Value:
    """The rows of a function of the program, in place."""
    if function.generates:
        raise ScenicError("unsupported", f"{function.name}() has a `yield`, which no match can do")
    bound = bind(function.name, function.arguments, function, arguments, keywords)
    code, outside, before = c.code, c.code.variables, c.code.place
    used = code.scratch.used
    code.variables = code.scratch
    try:
        with c.entered(function, node):
            names = {name: settled(code, value) for name, value in bound.items()}
            receiver = arguments[0] if function.owner is not None and arguments else None
            result, inlined = settled_call(c, function, names, receiver)
    except ScenicError as error:
        raise seen_from(scope, function, node, error) from None
    finally:
        code.place, code.variables = before, outside
        code.known.clear()
    code.temporaries.used = max(code.temporaries.used, inlined.level)
    result = out_of_the_way(code, result, used)
    code.scratch.used = used
    return result


def settled_call(
    c: Compilation, function: Function, names: dict[str, Value], receiver: Value
) -> tuple[Value, InlinedBody]:
    """The value of a call; its rows are written again if a shape of its variables has widened meanwhile."""
    code, path = c.code, c.path
    rows, doubts, reachable, known = len(code.rows), len(c.doubts), code.reachable, dict(code.known)
    temporaries, scratch = code.temporaries.used, code.scratch.used
    while True:
        inlined = InlinedBody(path, function.body if isinstance(function.body, list) else [], Label())
        inner = CompiledScope(c, function.scope.source, dict(names), function.scope, inlined)
        inner.assigned = function.assigned
        if receiver is not None:
            assert function.owner is not None
            inner.method = (function.owner, receiver)
        result = value_of(c, inner, function, inlined)
        own = {key for key in code.widened if key[: len(path)] == path}
        if not own:
            return result, inlined
        code.widened -= own
        code.relied_on = {key for key in code.relied_on if key[: len(path)] != path}
        del code.rows[rows:], c.doubts[doubts:]
        code.reachable, code.known = reachable, dict(known)
        code.temporaries.used, code.scratch.used = temporaries, scratch


def out_of_the_way(code: Assembler, value: Value, used: int) -> Value:
    """A function's value, copied out of the registers of its variables, which are free again."""
    if not varies(value):
        return value
    freed = range(code.scratch.base + used, code.scratch.base + code.scratch.used)
    shape = shape_of(value)
    parts = [part for _, part in pairs(shape, iter(range(shape.size)), value)]
    return copied(code, value) if any(each in freed for part in parts for each in registers_in(part)) else value


def value_of(c: Compilation, inner: CompiledScope, function: Function, inlined: InlinedBody) -> Value:
    if isinstance(function.body, ast.expr):
        return inner.value(function.body)
    try:
        inner.run(function.body)
    except Return as result:
        return result.value
    if inlined.result is None:
        return None
    if c.code.reachable:
        inlined.result.store(None)
    c.code.put(inlined.end)
    return inlined.result.value


def mutation(c: Compilation, scope: Scope, node: ast.Call) -> tuple[Value] | None:
    """`items.append(x)` and the like where `items` is a variable or an attribute: it becomes a changed list."""
    function = node.func
    if not (isinstance(function, ast.Attribute) and function.attr in METHODS):
        return None
    if not isinstance(function.value, ast.Name | ast.Attribute):
        return None
    items = scope.value(function.value)
    if not isinstance(items, list | RegisterList):
        return None
    holder: Environment = scope
    while not isinstance(holder, CompiledScope):
        assert holder.outer is not None
        holder = holder.outer
    arguments = [scope.value(each) for each in node.args]
    keywords = {each.arg: scope.value(each.value) for each in node.keywords if each.arg is not None}
    if appended_in_place(c, holder, function, items, arguments):
        return (None,)
    changed, result = mutated(c, scope, node, items, function.attr, arguments, keywords)
    if changed is not items:
        if isinstance(function.value, ast.Name):
            holder.assign_where_it_is(function.value.id, changed)
        else:
            set_attribute(c, holder, function.value, scope.value(function.value.value), changed)
    return (result,)


def appended_in_place(
    c: Compilation, scope: CompiledScope, function: ast.Attribute, items: Value, arguments: list
) -> bool:
    """Whether an element could be put at the end of the list of a variable as it stands in registers."""
    slot = scope.slots.get(function.value.id) if isinstance(function.value, ast.Name) else None
    if function.attr != "append" or not isinstance(items, RegisterList) or slot is None or len(arguments) != 1:
        return False
    slot.widen(RegisterList(shape_of(arguments[0]), ()))
    put_with_room(c, slot.value, arguments[0])
    return True
