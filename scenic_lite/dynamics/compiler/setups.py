"""What the statements of a setup mean when it is executed during a match: what they make belongs to its scenario.

`override`, `require monitor`, temporal `require`, `terminate when`, `terminate after`, `record`; the first three may
also stand in a compose block. Read next: `dynamics.compiler.watchers`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from typing import Any

from scenic_lite.core.state import Watched
from scenic_lite.core.types import BehaviorCall, Environment, Instance, RandomChoice, describe_kind
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, InlinedBody
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.interrupts import check_guards, frame_of
from scenic_lite.dynamics.compiler.parts import (
    BehaviorOverride,
    Monitor,
    Overridden,
    ScenarioInstance,
    Temporal,
    WatchedItem,
)
from scenic_lite.dynamics.compiler.registers import Variable, store_in_register
from scenic_lite.dynamics.compiler.watchers import Automaton
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.statements import keep_record, keep_termination
from scenic_lite.language.classes import checked
from scenic_lite.language.requirements import source_text
from scenic_lite.language.specifiers import overridden_property
from scenic_lite.language.temporal import formula_of
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value


def set_up(c: Compilation, part: ScenarioInstance) -> None:
    """Execute the setup of a scenario that begins; what it makes is kept by the part."""
    assert part.call is not None
    c.state.forget_watched()
    part.scope.run(part.call.behavior.scenario.setup)
    part.monitors = [monitor_of(c, call, c.flag_of(call)) for call in c.state.monitors]
    part.terminations = [WatchedItem(each, c.flag_of(each)) for each in c.state.terminations]
    part.records = [WatchedItem(each, c.flag_of(each)) for each in c.state.records]


def flag_if_live(c: Compilation, scope: CompiledScope, thing: object) -> None:
    """Note whether a match comes to a statement, if that is not certain."""
    if scope.inlined.live:
        refuse_repeated(c)
        assert c.site.part is not None
        flag = c.site.part.flagged(c.code)
        c.flags[id(thing)] = thing, flag
        register_of(c.code, 1, flag)


def refuse_repeated(c: Compilation) -> None:
    if c.site.repeating:
        raise ScenicError("unsupported", "this cannot be repeated in a match", hint="write it before the loop")


def keep_condition(c: Compilation, scope: CompiledScope, node: nodes.TerminateWhen | nodes.TerminateAfter) -> None:
    keep_termination(scope, node)
    flag_if_live(c, scope, c.state.terminations[-1])


def keep_value(c: Compilation, scope: CompiledScope, node: nodes.Record) -> None:
    keep_record(scope, node)
    flag_if_live(c, scope, c.state.records[-1])


def refuse_param(c: Compilation, scope: CompiledScope, node: ast.stmt) -> None:
    word = "param" if isinstance(node, nodes.Param) else "mutate"
    raise ScenicError("unsupported", f"`{word}` has no meaning in a match", hint="write it in the main scenario")


# ------------------------------------------------------------ monitors


def require_monitor(c: Compilation, scope: CompiledScope, node: nodes.RequireMonitor) -> None:
    """Start a monitor with the scenario, or at once if that is running."""
    value = scope.value(node.call)
    if not isinstance(value, BehaviorCall) or value.behavior.kind != "monitor":
        raise scope.error("type", f"`require monitor` needs a monitor, not {describe_kind(value)}", node.call)
    call = with_own_arguments(c, value)
    if c.site.setting_up:
        c.state.monitors.append(call)
        flag_if_live(c, scope, call)
        return
    refuse_repeated(c)
    assert c.site.part is not None
    monitor = monitor_of(c, call, None)
    c.site.part.monitors.append(monitor)
    start_monitor(c, monitor)


def with_own_arguments(c: Compilation, call: BehaviorCall) -> BehaviorCall:
    """Return a behavior or monitor whose arguments stay as they are now."""
    return BehaviorCall(
        call.behavior, {name: store_in_register(c.code, each) for name, each in call.arguments.items()}, call.place
    )


def monitor_of(c: Compilation, call: BehaviorCall, flag: int | None) -> Monitor:
    slot = c.code.fixed.take()
    c.code.notes[slot] = f"{call.behavior.name}.slot"
    return Monitor(call, slot, Label(), flag)


def start_monitor(c: Compilation, monitor: Monitor) -> None:
    """Check its guards and let it begin."""
    with nullcontext() if monitor.flag is None else c.code.when(monitor.flag):
        check_first(c, monitor.call)
        c.code.row(op.SET_SLOT, monitor.slot, c=monitor.entry)


def check_first(c: Compilation, call: BehaviorCall) -> None:
    """Check the guards of what begins."""
    node = call.behavior.node
    if node.preconditions or node.invariants:
        with c.round(node, len(c.output.rejections)), c.entered(call.behavior, node):
            check_guards(c, frame_of(c, call))


# ------------------------------------------------------------ override


def override(c: Compilation, scope: CompiledScope, node: nodes.Override) -> None:
    """Compile `override object with p v, ...`, until the scenario ends."""
    target = scope.value(node.target)
    if isinstance(target, RandomChoice):
        raise ScenicError("unsupported", "`override` of whichever object a match finds")
    if not isinstance(target, Instance) or not target.label:
        raise scope.error("type", f"`override` needs an object, not {describe_kind(target)}", node.target)
    values: dict[str, Value] = {}
    for each in node.specifiers:
        name, value = overridden_property(scope, each)
        if name in c.shown.names:
            raise scope.error("specifier", f"'{name}' is of the simulator and cannot be overridden", each)
        if name not in target.properties:
            raise scope.error("specifier", f"{target.title()} has no property '{name}' to override", each)
        values[name] = value if isinstance(value, RandomChoice) else checked(name, value, c.program.dialect)
    part = c.site.part
    assert part is not None
    overrides = []
    for name, value in values.items():
        if name == "behavior":
            overrides = override_behavior(c, part, target, value)
        else:
            override_property(c, part, target, name, value)
    begin_override(c, values.get("behavior"), overrides)


def override_property(c: Compilation, part: ScenarioInstance, target: Instance, name: str, value: Value) -> None:
    """Give another value to a property that no simulator knows."""
    c.refuse_live(target, name)
    key = ("object", target.label, name)
    before = Variable(c.code, c.types, (*part.scope.inlined.path, "before", *key), shared=True)
    save = lambda: before.store(c.shared_variable(key).load())  # noqa: E731
    note_first(c, part, (target.label, name), save, lambda: c.keep(key, before.load()))
    c.keep(key, value)


Rows = Callable[[], object]  # what writes some


def note_first(c: Compilation, part: ScenarioInstance, key: tuple[str, str], save: Rows, restore: Rows) -> None:
    """Save what a property was before its first override in a scenario."""
    if key not in part.overridden:
        part.overridden[key] = Overridden(c.code.fixed.take(), save, restore)
    first, done = part.overridden[key], Label()
    c.code.row(op.JUMP_IF, first.flag, c=done)
    first.save()
    register_of(c.code, 1, first.flag)
    c.code.put(done)


def override_behavior(c: Compilation, part: ScenarioInstance, target: Instance, value: Value) -> list[BehaviorOverride]:
    """Give an object another behavior, or one of several: its register says which one it has now."""
    code, label = c.code, target.label
    if label not in c.overrides.registers:
        c.overrides.registers[label] = code.fixed.take()
        code.notes[c.overrides.registers[label]] = f"{target.title()}.behavior"
        c.overrides.behaviors[label] = []
    register, before = c.overrides.registers[label], code.fixed.take()
    save = lambda: register_of(code, RegisterValue(register), before)  # noqa: E731
    note_first(c, part, (label, "behavior"), save, lambda: register_of(code, RegisterValue(before), register))
    if value is None:
        register_of(code, -1, register)
        return []
    options = value.options if isinstance(value, RandomChoice) else (value,)
    overrides = [driver_of(c, part, target, option) for option in options]
    if isinstance(value, RandomChoice):
        code.row(op.ADD, register, code.constant(overrides[0].number), register_of(code, value.index))
    else:
        register_of(code, overrides[0].number, register)
    return overrides


def driver_of(c: Compilation, part: ScenarioInstance, target: Instance, call: Value) -> BehaviorOverride:
    if not isinstance(call, BehaviorCall):
        checked("behavior", call, c.program.dialect)
    assert isinstance(call, BehaviorCall)
    known = c.overrides.behaviors[target.label]
    slot = c.code.fixed.take()
    driver = BehaviorOverride(target, with_own_arguments(c, call), slot, Label(), 1 + len(known), part)
    known.append(driver)
    return driver


def begin_override(c: Compilation, value: Value, overrides: list[BehaviorOverride]) -> None:
    """Check the guards of the behavior that an object is given, and let it begin."""
    cases = {i: partial(begin_one, c, each) for i, each in enumerate(overrides)}
    if isinstance(value, RandomChoice):
        c.code.dispatch(register_of(c.code, value.index), cases)
    elif overrides:
        cases[0]()


def begin_one(c: Compilation, behavior: BehaviorOverride) -> None:
    with c.acting(behavior.agent):
        check_first(c, behavior.call)
    c.code.row(op.SET_SLOT, behavior.slot, c=behavior.entry)


# ------------------------------------------------------------ temporal requirements


def require_later(c: Compilation, scope: CompiledScope, node: nodes.Require) -> None:
    """Make a temporal requirement during the match: its scenario watches it from the next step on."""
    refuse_repeated(c)
    part, code = c.site.part, c.code
    assert part is not None
    label = node.name or source_text(scope, node)
    own = with_present_names(c, scope, node)
    watched = Watched(node, scope.place(node), own, label)
    state = part.flagged(code, -1)
    part.temporal.append(Temporal(watched, own, Automaton(formula_of(node.condition)), state))
    register_of(code, 0, state)


def with_present_names(c: Compilation, scope: CompiledScope, node: nodes.Require) -> CompiledScope:
    """Return a frame in which the names of a condition keep the values that they have now."""
    code = c.code
    names: dict[str, Value] = {}
    used = {each.id for each in ast.walk(node.condition) if isinstance(each, ast.Name)}
    at: Environment | None = scope
    outside, code.variables = code.variables, code.fixed
    while isinstance(at, CompiledScope):
        for name in sorted(used & set(at.locals) - set(names)):
            names[name] = store_in_register(code, at.locals[name])
        at = at.outer
    code.variables = outside
    return CompiledScope(
        c, scope.source, names, scope, InlinedBody((*c.site.path, id(node)), Label(), scope.inlined.behavior)
    )


SETTING_UP: dict[type, Callable[[Compilation, CompiledScope, Any], None]] = {
    nodes.Override: override,
    nodes.RequireMonitor: require_monitor,
    nodes.TerminateWhen: keep_condition,
    nodes.TerminateAfter: keep_condition,
    nodes.Record: keep_value,
    nodes.Param: refuse_param,
    nodes.Mutate: refuse_param,
}
