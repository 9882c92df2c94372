"""Scenarios in a match: every `do` of a compose block creates inner scenarios, which begin, take steps, and end.

`tests/reference/scenarios.py` defines the semantics. The whole tree of scenarios is one thread. The program's own
scenario takes a step, and its compose block resumes at its slot; the inner scenarios do the same. When time passes in a
compose block, it stores its resumption row and jumps to the end of its scenario's step. A routine can end a scenario
from any place. Objects and statements that a setup creates belong to its scenario. A compose block may also contain
some of these statements.
Read next: `dynamics.compiler.watchers`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from scenic_lite.core.state import EpisodeStatement
from scenic_lite.core.types import BehaviorCall, Environment, Instance, RandomChoice, choose
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import (
    Compilation,
    CompiledScope,
    InlinedBody,
    Key,
    ScenarioInstance,
    Thread,
    WatchedItem,
)
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.interrupts import check_guards, check_invariants, frame_of, pause, suspend
from scenic_lite.dynamics.compiler.registers import Variable, store_in_register
from scenic_lite.dynamics.compiler.statements import assigned_names
from scenic_lite.dynamics.compiler.watchers import Automaton, conditions, limit_of, take_records, unsatisfied
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import COMPLETE
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.statements import keep_record, keep_termination
from scenic_lite.evaluation.statements import require_monitor as keep_monitor
from scenic_lite.language.classes import checked
from scenic_lite.language.requirements import formula_of, source_text
from scenic_lite.language.specifiers import overridden_properties
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value

DEFINING = (ast.FunctionDef, ast.Lambda, ast.ClassDef, nodes.Behavior, nodes.Scenario)
BEHAVIOR = "(number of its behavior)"  # per object: 0 for its initial behavior, then behaviors from scenarios
NOBODY = -1  # the number for no behavior


def main_part(c: Compilation) -> ScenarioInstance:
    """Return the loaded program as a scenario, with the variables of its setup."""
    program, code, main = c.program, c.code, c.program.main
    part = ScenarioInstance(code, None, main)
    part.ego = c.state.ego
    code.begin_with(part.running, 1)
    if main is not None and program.main_frame is not None:
        loaded, behavior = program.main_frame, main.behavior
        inlined = InlinedBody((id(behavior.node),), Label(), behavior)
        assert loaded.outer is not None
        part.scope = CompiledScope(c, loaded.source, loaded.locals, loaded.outer, inlined)
        part.scope.assigned = behavior.assigned
    for call in program.monitors:
        monitor = add_monitor(c, part, call)
        c.output.starting[monitor.slot] = monitor.entry
    part.terminations = [WatchedItem(item) for item in program.terminations]
    part.records = [WatchedItem(item) for item in program.records]
    for item in program.temporal:
        part.temporal.append(WatchedItem(item, code.fixed.take(), Automaton(formula_of(item.tree.condition))))
    c.output.starting[part.slot] = part.beginning
    return part


# ------------------------------------------------------------ `do` of scenarios
def run_scenarios(c: Compilation, calls: list[Value], node: nodes.Do) -> None:
    """Begin all named scenarios in order; then let each take steps until all have ended."""
    code = c.code
    parts: list[ScenarioInstance] = []
    for call in calls:
        if isinstance(call, RandomChoice):  # the match chooses one of the options
            cases = {i: partial(begin, c, option, node, parts) for i, option in enumerate(call.options)}
            code.dispatch(register_of(code, call.index), cases)
        else:
            begin(c, call, node, parts)
    again, on, end = Label(), Label(), Label()
    code.put_loop(again)
    for part in parts:
        step(c, part)
        show_names(part)
    for part in parts:
        code.row(op.JUMP_IF, part.running, c=on)
    code.row(op.JUMP, c=end)
    code.put(on)
    suspend(c, again)
    code.put(end)


def begin(c: Compilation, call: BehaviorCall, node: nodes.Do, parts: list[ScenarioInstance]) -> None:
    """Write rows that check the guards of a scenario, execute its setup, and start its time limit and its monitors."""
    code, parent = c.code, c.site.part
    assert parent is not None
    with c.round(node, len(parent.parts)), c.entered(call.behavior, node, call.place):
        part = ScenarioInstance(code, parent, call)
        for family in (parent.parts, parts):
            family.append(part)
        part.site = replace(c.site, part=part, composing=False, repeating=0)
        part.ego, part.scope = c.state.ego, frame_of(c, call)
        del part.scope.locals["self"]
        check_guards(c, part.scope)
        with c.within(part, setting_up=True):
            part.scope.run(call.behavior.scenario.setup)
            while c.state.monitors:  # in Scenic 2, a definition starts its monitor
                add_monitor(c, part, c.state.monitors.pop(0))
        register_of(code, 1, part.running)
        if call.behavior.scenario.acts:
            code.row(op.SET_SLOT, part.slot, c=part.beginning)
        with c.within(part):
            with code.statement():
                limit_of(c, part)
            for monitor in part.monitors:
                with code.statement():
                    launch(c, monitor)
            take_records(c, part, "initial")
        show_names(part)
    if parent.ego is None:
        c.state.ego = part.ego


def show_names(part: ScenarioInstance) -> None:
    """Provide the variables of a scenario as its attributes."""
    assert part.call is not None
    part.call.names.clear()
    part.call.names.update(part.scope.locals)


# ------------------------------------------------------------ a step, and the end
def step(c: Compilation, part: ScenarioInstance) -> None:
    """Write one step of a scenario: its requirements, time limit, compose block and conditions."""
    code, done = c.code, Label()
    if part.parent is not None:
        code.row(op.JUMP_UNLESS, part.running, c=done)
    code.put(part.progress)
    if part.limit is not None:
        (taken, allowed), going = part.limit, Label()
        code.row(op.JUMP_LESS, taken, allowed, going)
        ended(c, part, "reached time limit")
        code.put(going)
        code.row(op.ADD, taken, taken, code.constant(1))
    if part.call is not None and part.call.behavior.scenario.acts:
        with c.within(part, composing=True, slot=part.slot):
            compose(c, part)
    with c.within(part):
        conditions(c, part, "scenario", partial(ended, c, part))
    if part.over.used or part.kill.used:
        code.row(op.JUMP, c=done)
        code.put(part.over)
        part.call_stop(code)
        code.row(op.JUMP, c=done)
        code.put(part.kill)
        part.call_stop(code)
        if part.parent is not None:
            code.row(op.JUMP, c=part.parent.kill)
    code.put(done)


def ended(c: Compilation, part: ScenarioInstance, reason: str) -> None:
    """Write rows that end a scenario; the end of the program's own scenario ends the match."""
    if part.parent is None:
        register_of(c.code, RegisterValue(c.reason(f"scenarioComplete: {reason}")), COMPLETE)
    c.code.row(op.JUMP, c=part.over)


def compose(c: Compilation, part: ScenarioInstance) -> None:
    """Write the compose block and its resumption; without a compose block, check the guards while time passes."""
    code, scope = c.code, part.scope
    assert part.call is not None
    node = part.call.behavior.scenario
    code.row(op.RESUME, part.slot)
    code.put_reachable(part.beginning)
    if node.compose:
        scope.pin(watched_names(part, node))
        scope.run(node.compose)
        code.put(scope.inlined.end)
        ended(c, part, "finished compose block")
    else:
        pause(c)
        check_invariants(c, scope)
        code.row(op.JUMP, c=part.after)  # the next step resumes at the same row
    code.put(part.after)


def watched_names(part: ScenarioInstance, node: nodes.Scenario) -> frozenset[str]:
    """Return the variables that a compose block assigns and that the scenario's monitors may read."""
    loops = [part for tree in node.compose for part in ast.walk(tree) if isinstance(part, ast.For)]
    changed = names_in(*(loop.target for loop in loops)) | assigned_names(*node.compose)
    watching: list[ast.AST] = [item.watched.tree for item in (*part.terminations, *part.records)]
    watching += [part for tree in node.setup for part in ast.walk(tree) if isinstance(part, DEFINING)]
    return changed & names_in(*watching)


def names_in(*trees: ast.AST) -> frozenset[str]:
    return frozenset(node.id for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Name))


def stop(c: Compilation, part: ScenarioInstance) -> None:
    """Write the `stop` routine: final records, end of inner scenarios, reset of overrides, violated requirements."""
    code, out = c.code, Label()
    code.row(op.JUMP_UNLESS, part.running, c=out)
    register_of(code, 0, part.running)
    if part.parent is not None:
        take_records(c, part, "final")
    for sub in part.parts:
        sub.call_stop(code)
    for key, (flag, before) in part.overridden.items():
        with code.when(flag), code.statement():
            c.keep(key, before.load())
    unsatisfied(c, part)
    if part.parent is not None:
        for register, value in part.resets:
            register_of(code, value, register)
    code.put(out)


# ------------------------------------------------------------ statements of a setup
def own_part(c: Compilation, scope: CompiledScope) -> ScenarioInstance:
    """Return the scenario that owns a statement's results. Raises ScenicError unless it certainly runs once."""
    where, uncertain = ("branch", scope.inlined.live) if c.site.setting_up else ("loop", c.site.repeating)
    if uncertain:
        raise ScenicError("unsupported", f"no match can make this in a {where}", hint=f"write it before the {where}")
    assert c.site.part is not None
    return c.site.part


def watch(
    c: Compilation, scope: CompiledScope, node: nodes.TerminateWhen | nodes.TerminateAfter | nodes.Record
) -> None:
    """Add a condition, a time limit or a record to the scenario."""
    part = own_part(c, scope)
    if isinstance(node, nodes.Record):
        keep_record(scope, node)
        part.records.append(WatchedItem(c.state.records.pop()))
    else:
        keep_termination(scope, node)
        watched = c.state.terminations.pop()
        part.terminations.append(WatchedItem(watched._replace(duration=store_in_register(c.code, watched.duration))))


def require_monitor(c: Compilation, scope: CompiledScope, node: nodes.RequireMonitor) -> None:
    """Start a monitor together with its scenario, or immediately if the scenario is running."""
    keep_monitor(scope, node)
    thread = add_monitor(c, own_part(c, scope), with_own_arguments(c, c.state.monitors.pop()))
    if not c.site.setting_up:
        launch(c, thread)


def with_own_arguments(c: Compilation, call: BehaviorCall) -> BehaviorCall:
    """Return a call of a behavior or monitor whose arguments keep their present values."""
    return replace(call, arguments={name: store_in_register(c.code, value) for name, value in call.arguments.items()})


def add_monitor(c: Compilation, part: ScenarioInstance, call: BehaviorCall) -> Thread:
    where = "" if part.parent is None else f" of {part.name}"
    title = f"monitor {call.behavior.name}{where}"
    part.monitors.append(Thread(title, part.register(c.code), call, number=len(part.monitors)))
    c.code.register_names[part.monitors[-1].slot] = f"{call.behavior.name}.slot"
    return part.monitors[-1]


def launch(c: Compilation, thread: Thread) -> None:
    """Check the guards of a monitor or behavior, and start it."""
    check_first(c, thread)
    c.code.row(op.SET_SLOT, thread.slot, c=thread.entry)


def check_first(c: Compilation, thread: Thread) -> None:
    """Check the guards of a thread at its start."""
    assert thread.call is not None
    node = thread.call.behavior.node
    if node.preconditions or node.invariants:
        started = c.entered(thread.call.behavior, node, thread.call.place)
        with c.at(agent=thread.agent), c.round(node, len(c.output.rejections)), started:
            check_guards(c, frame_of(c, thread.call))


# ------------------------------------------------------------ override
def override(c: Compilation, scope: CompiledScope, node: nodes.Override) -> None:
    """Compile `override object with p v, ...`, which holds until the end of the scenario."""
    target = scope.value(node.target)
    if isinstance(target, RandomChoice):
        raise ScenicError("unsupported", "`override` of an object that the match chooses")
    values = overridden_properties(scope, node, target, c.shown.names)
    for name, value in values.items():
        if name != "behavior":
            c.refuse_live(target, name)
            set_until_end(c, ("object", target.label, name), value)
    if "behavior" in values:
        override_behavior(c, target, values["behavior"])


def set_until_end(c: Compilation, key: Key, value: Value) -> None:
    """Override an object's property; the end of the scenario restores the previous value."""
    part, code, done = c.site.part, c.code, Label()
    assert part is not None
    if key not in part.overridden:
        before = Variable(code, c.types, (*part.site.path, "before", *key), shared=True)
        part.overridden[key] = part.register(code), before
    flag, before = part.overridden[key]
    code.row(op.JUMP_IF, flag, c=done)
    before.store(c.shared_variable(key).load())
    register_of(code, 1, flag)
    code.put(done)
    c.keep(key, value)


def override_behavior(c: Compilation, target: Instance, value: Value) -> None:
    """Override an object's behavior by one or several; a register holds the number of the present behavior."""
    numbers, cases = [], {}
    known = c.overrides.setdefault(target.label, [])
    for i, call in enumerate(value.options if isinstance(value, RandomChoice) else (value,)):
        numbers.append(NOBODY)
        call = checked("behavior", call, c.program.dialect)
        if call is not None:
            assert c.site.part is not None
            title = f"{target.title()}: {call.behavior.name} (override in {c.site.part.name})"
            numbers[-1] = 1 + len(known)
            known.append(Thread(title, c.code.fixed.take(), with_own_arguments(c, call), target, number=numbers[-1]))
            cases[i] = partial(launch, c, known[-1])
    key = ("object", target.label, BEHAVIOR)
    if isinstance(value, RandomChoice):
        set_until_end(c, key, choose(value.index, numbers))
        c.code.dispatch(register_of(c.code, value.index), cases)
    else:
        set_until_end(c, key, numbers[0])
        for write in cases.values():
            write()


# ------------------------------------------------------------ temporal requirements
def require_later(c: Compilation, scope: CompiledScope, node: nodes.Require) -> None:
    """Create a temporal requirement during the match; its scenario monitors it from the next step on."""
    part, own = own_part(c, scope), with_present_names(c, scope, node)
    watched = EpisodeStatement(node, scope.place(node), own, node.name or source_text(scope, node))
    state = part.register(c.code, -1)
    part.temporal.append(WatchedItem(watched, state, Automaton(formula_of(node.condition)), own))
    register_of(c.code, 0, state)


def with_present_names(c: Compilation, scope: CompiledScope, node: nodes.Require) -> CompiledScope:
    """Return a frame in which the names of a condition keep their present values."""
    code, names = c.code, dict[str, Value]()
    at: Environment | None = scope
    outside, code.variables = code.variables, code.fixed
    while isinstance(at, CompiledScope):
        for name in sorted(names_in(node.condition) & set(at.locals) - set(names)):
            names[name] = store_in_register(code, at.locals[name])
        at = at.outer
    code.variables = outside
    inlined = InlinedBody((*c.site.path, id(node)), Label(), scope.inlined.behavior)
    return CompiledScope(c, scope.source, names, scope, inlined)


SETTING_UP: dict[type, Callable[[Compilation, CompiledScope, Any], None]] = {
    nodes.Override: override,
    nodes.RequireMonitor: require_monitor,
    nodes.TerminateWhen: watch,
    nodes.TerminateAfter: watch,
    nodes.Record: watch,
}
