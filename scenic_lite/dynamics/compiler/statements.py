"""Python's statements: assignments, branches, loops, `return`, `assert`.

The compiler resolves fixed values: of a branch on `self.team == "right"` only one side remains, and a loop over a fixed
list is unrolled. Live values become jumps. Read next: `dynamics.compiler.behaviors`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from copy import copy
from functools import lru_cache
from typing import Any

from scenic_lite.core.types import BehaviorCall, Function, Instance, RandomChoice, describe_kind, near
from scenic_lite.core.world import NOT_FINITE, checked_reward
from scenic_lite.dynamics.compiler.choices import branch, jump_on
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import OWN, SHARED, Compilation, CompiledScope, Loop
from scenic_lite.dynamics.compiler.emit import fault_unless_finite, register_of
from scenic_lite.dynamics.compiler.lists import LiveRange, appended, elements, loop, many, one_list
from scenic_lite.dynamics.compiler.registers import Variable, materialize, store_in_register
from scenic_lite.dynamics.compiler.types import RegisterList
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import REWARD
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.access import TRACKED, spread
from scenic_lite.evaluation.calls import Return
from scenic_lite.evaluation.expressions import combine
from scenic_lite.language.classes import checked
from scenic_lite.language.requirements import source_text
from scenic_lite.syntax import nodes
from scenic_lite.syntax.nodes import suspends, walk_own
from scenic_lite.values.graph import RandomExpr, Value


def expression(c: Compilation, scope: CompiledScope, node: ast.Expr) -> None:
    if isinstance(node.value, ast.Call) and append(c, scope, node.value):
        return
    value = materialize(c.code, scope.value(node.value))
    if isinstance(value, BehaviorCall):
        name = value.behavior.name
        message = f'the {value.behavior.kind} "{name}" is named here, but not run'
        c.output.diagnostics.append(scope.error("warning", message, node, f"write do {name}(...)"))
    elif isinstance(value, int) and not scope.source.library and is_library_call(scope, node.value):
        text = source_text(scope, node)
        c.output.diagnostics.append(scope.error("warning", "this value is not used", node, f"write take {text}"))


def is_library_call(scope: CompiledScope, node: ast.expr) -> bool:
    """Return whether an expression calls a library function by its name."""
    called = scope.value(node.func) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else None
    return isinstance(called, Function) and called.scope.source.library


# ------------------------------------------------------------ assignments
def assign(c: Compilation, scope: CompiledScope, node: ast.Assign) -> None:
    value = scope.value(node.value)
    for target in node.targets:
        bind(c, scope, target, value)


def augmented(c: Compilation, scope: CompiledScope, node: ast.AugAssign) -> None:
    old = copy(node.target)
    old.ctx = ast.Load()
    bind(c, scope, node.target, combine(scope, node.op, scope.value(old), scope.value(node.value)))


def bind(c: Compilation, scope: CompiledScope, target: ast.expr, value: Value) -> None:
    """Assign to a name, several names, an element or an attribute."""
    if isinstance(target, ast.Name):
        track(c, scope, target, value)
        scope.assign(target.id, value)
    elif isinstance(target, ast.Tuple | ast.List):
        parts = spread(scope, target, elements(c, scope, value, target))
        parts = [store_in_register(c.code, value) for value in parts]  # copies, for `a, b = b, a`
        for element, part in zip(target.elts, parts, strict=True):
            bind(c, scope, element, part)
    elif isinstance(target, ast.Attribute):
        set_attribute(c, scope, target, scope.value(target.value), value)
    elif isinstance(target, ast.Subscript):
        hint = "make another: [value, *items[1:]]; or use a variable for each of them"
        raise ScenicError("unsupported", "elements cannot be assigned in a match", hint=hint)
    else:
        raise scope.error("syntax", "this cannot be assigned to", target)


def track(c: Compilation, scope: CompiledScope, target: ast.Name, value: Value) -> None:
    """Handle `ego = ...` in the setup of a scenario during a match; it holds until the end of the scenario."""
    if target.id not in TRACKED:
        return
    part = c.site.part
    own = c.site.setting_up and part is not None and part.scope is scope and not scope.inlined.live
    if not own:
        hint = "only the setup of a scenario may, and not in a branch"
        raise ScenicError("unsupported", f"no match can change {target.id} here", hint=hint)
    TRACKED[target.id](scope, target, value)


def append(c: Compilation, scope: CompiledScope, node: ast.Call) -> bool:
    """Compile `items.append(x)` if `items` is a variable or an attribute; return whether the call has this form."""
    function = node.func
    if not (isinstance(function, ast.Attribute) and function.attr == "append" and len(node.args) == 1):
        return False
    target = function.value
    items = scope.value(target) if isinstance(target, ast.Name | ast.Attribute) else None
    if not isinstance(items, list | RegisterList):
        return False
    if isinstance(target, ast.Name) and target.id not in scope.locals:
        message = f"a match cannot append to '{target.id}', which is not of this {OWN}"
        raise ScenicError("unsupported", message, hint=SHARED)
    bind(c, scope, target, appended(c, items, scope.value(node.args[0])))
    return True


# ------------------------------------------------------------ attributes
def set_attribute(c: Compilation, scope: CompiledScope, target: ast.Attribute, owner: Value, value: Value) -> None:
    """Compile `owner.name = value`, which is visible to all behaviors of the match."""
    name = target.attr
    if owner is c.simulation:
        if name != "scenic_reward":
            message, hint = f"a match sets no attribute '{name}' of simulation()", near(name, ["scenic_reward"])
            raise ScenicError("unsupported", message, hint=hint or SHARED)
        register_of(c.code, checked_reward(value), REWARD)
        if isinstance(value, RandomExpr):
            fault_unless_finite(c.code, REWARD, NOT_FINITE)
        c.output.sets_reward = True
    elif isinstance(owner, Instance) and owner.label:
        c.refuse_live(owner, name)
        value = checked(name, value, c.program.dialect) if name in owner.properties else value
        c.keep(("object", owner.label, name), value)
    elif isinstance(owner, RandomChoice):
        raise ScenicError("unsupported", "attributes can be set on one object, not on one that the match chooses")
    else:
        raise ScenicError("type", f"the attributes of {describe_kind(owner)} cannot be assigned")


# ------------------------------------------------------------ branches and loops
def compile_if(c: Compilation, scope: CompiledScope, node: ast.If) -> None:
    no, end = Label(), Label()
    with c.code.captured() as rows:
        jump_on(c, scope, node.test, no, when=False)
        reachable = c.code.reachable
    c.code.reachable = True
    live = no.used and reachable
    if live:  # before the test, since a side that assigns a variable may not run
        scope.pin(assigned_names(*node.body, *node.orelse))
    c.code.rows.extend(rows)
    c.code.reachable = reachable
    unset, before = set[str](), set(scope.unset)
    with scope.in_dynamic_branch() if live else nullcontext():
        for side in (node.body, node.orelse):
            scope.unset = set(before)
            scope.run(side)
            unset |= scope.unset if c.code.reachable else set()
            if side is node.body:
                if node.orelse:
                    c.code.row(op.JUMP, c=end)
                c.code.put(no)
    scope.unset = unset
    c.code.put(end)


def compile_while(c: Compilation, scope: CompiledScope, node: ast.While) -> None:
    scope.pin(assigned_names(node.test, *node.body))
    again, failed, around = Label(), Label(), Loop(Label(), Label())
    c.code.put_loop(again)
    jump_on(c, scope, node.test, failed, when=False)
    with scope.in_dynamic_branch():
        in_loop(scope, around, node.body)
        c.code.put(around.again)
        c.code.row(op.LOOP_BACK, c=again)
        c.code.put(failed)
        scope.run(node.orelse)
    c.code.put(around.exit)


def in_loop(scope: CompiledScope, around: Loop, body: list[ast.stmt]) -> None:
    around.parts = scope.compilation.scenarios_begun()
    scope.inlined.loops.append(around)
    try:
        with scope.compilation.repeated():
            scope.run(body)
    finally:
        scope.inlined.loops.pop()


def compile_for(c: Compilation, scope: CompiledScope, node: ast.For) -> None:
    """Compile a loop: a shared body for numbers, a list of the match or many objects, else one body per element."""
    items = one_list(c, scope.value(node.iter))
    if isinstance(items, range) and len(items) > 0:
        items = LiveRange(items.start, items.stop, items.step)
    if isinstance(items, RegisterList):
        items = store_in_register(c.code, items)  # the loop iterates over the list at its start
    elif not isinstance(items, LiveRange):
        items = elements(c, scope, items, node.iter)
        if not many(items) or needs_one_object(node):
            unroll(c, scope, node, items)
            return
    scope.pin(assigned_names(*node.body))
    exit_ = Label()
    with scope.in_dynamic_branch():
        with loop(c.code, items) as (item, _, following):
            bind(c, scope, node.target, item)
            in_loop(scope, Loop(exit_, following), node.body)
        scope.run(node.orelse)
    c.code.put(exit_)


def needs_one_object(node: ast.For) -> bool:
    """Return whether the body of a loop can be compiled only for a known object."""
    names = {part.id for part in ast.walk(node.target) if isinstance(part, ast.Name)}

    def of_one(part: ast.AST) -> bool:
        if isinstance(part, ast.Attribute) and isinstance(part.ctx, ast.Store):
            return isinstance(part.value, ast.Name) and part.value.id in names
        return isinstance(part, nodes.Override | nodes.Do | nodes.RequireMonitor)

    return any(map(of_one, walk_own(*node.body)))


def unroll(c: Compilation, scope: CompiledScope, node: ast.For, items: list[Value]) -> None:
    """Compile a loop over a fixed list; every iteration has separate rows with a known element."""
    code = c.code
    keep = store_in_register if suspends(*node.body) else materialize
    items = [keep(code, item) for item in items]
    jumps = [part for part in walk_own(*node.body) if isinstance(part, ast.Break | ast.Continue)]
    if jumps:
        scope.pin(assigned_names(*node.body))
    exit_ = Label()
    for i, item in enumerate(items):
        around = Loop(exit_, Label())
        with c.round(node, i), code.statement():
            bind(c, scope, node.target, item)
            in_loop(scope, around, node.body)
            code.put(around.again)
    scope.run(node.orelse)
    code.put(exit_)
    if exit_.used:
        targets = {part.id for part in ast.walk(node.target) if isinstance(part, ast.Name)}
        scope.unset |= targets - scope.variables.keys()


def leave_round(c: Compilation, scope: CompiledScope, node: ast.Break | ast.Continue) -> None:
    """Compile `break` and `continue`, which end the scenarios that the iteration has begun."""
    around = scope.inlined.loops[-1]
    c.stop_scenarios(around.parts)
    c.code.row(op.JUMP, c=around.exit if isinstance(node, ast.Break) else around.again)


def compile_return(c: Compilation, scope: CompiledScope, node: ast.Return) -> None:
    """Compile `return`, from a behavior or from a function; registers hold the value if there are several returns."""
    inlined = scope.inlined
    if inlined.behavior is not None:
        c.code.row(op.JUMP, c=inlined.end)
        return
    value = None if node.value is None else scope.value(node.value)
    if inlined.live == 0 and inlined.result is None and not inlined.loops:
        raise Return(materialize(c.code, value, c.code.variables))
    if inlined.result is None:
        inlined.result = Variable(c.code, c.types, (*inlined.path, "return"))
    inlined.result.store(value)
    c.code.row(op.JUMP, c=inlined.end)


# ------------------------------------------------------------ others
def compile_assert(c: Compilation, scope: CompiledScope, node: ast.Assert) -> None:
    """Stop the match with a fault if a condition does not hold."""
    with branch(c, scope, node.test, when=False):
        c.code.row(op.FAULT, note="the assertion does not hold")


def refuse(c: Compilation, scope: CompiledScope, node: ast.stmt) -> None:
    raise ScenicError("unsupported", "this has no meaning in a match", hint="write it outside of behaviors")


# ------------------------------------------------------------ assigned variables
@lru_cache(maxsize=4096)
def assigned_names(*trees: ast.AST) -> frozenset[str]:
    """Return the variables that some statements assign, except loop targets, which the loop itself assigns."""
    names: set[str] = set()
    for node in walk_own(*trees):
        if isinstance(node, ast.Assign):
            targets: list[ast.expr] = node.targets
        elif isinstance(node, ast.AugAssign):
            targets = [node.target]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "append":
            targets = [node.func.value]
        else:
            continue
        for target in targets:
            names |= {part.id for part in base_names(target)}
    return frozenset(names)


def base_names(target: ast.expr) -> Iterator[ast.Name]:
    """Yield the variables that an assignment to a target changes."""
    if isinstance(target, ast.Name):
        yield target
    elif isinstance(target, ast.Tuple | ast.List):
        for element in target.elts:
            yield from base_names(element)


STATEMENTS: dict[type, Callable[[Compilation, CompiledScope, Any], None]] = {
    ast.Expr: expression,
    ast.Assign: assign,
    ast.AugAssign: augmented,
    ast.If: compile_if,
    ast.While: compile_while,
    ast.For: compile_for,
    ast.Break: leave_round,
    ast.Continue: leave_round,
    ast.Return: compile_return,
    ast.Assert: compile_assert,
    **dict.fromkeys((ast.ClassDef, nodes.Param, nodes.Mutate), refuse),
}
