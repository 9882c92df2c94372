"""Scenarios in a match: every `do` of a compose block becomes parts, which begin, take a step at each time, and end.

What each of this means is `dynamics.scenarios`' to say. The whole tree of scenarios is one thread: the program's own
takes a step, its compose block goes on where its slot says, and in that the parts that it runs take theirs. Where a
compose block lets time pass it notes where to go on and jumps to the end of its scenario's step. Routines end a
scenario from wherever that happens. Read next: `dynamics.compiler.setups`, the statements of a setup;
`dynamics.compiler.watchers`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from contextlib import contextmanager

from scenic_lite.core.types import BehaviorCall, RandomChoice
from scenic_lite.dynamics.compiler.code import Label
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, InlinedBody, assigned_names
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.interrupts import check_guards, check_invariants, frame_of, pause, suspend
from scenic_lite.dynamics.compiler.parts import ScenarioInstance, part_of
from scenic_lite.dynamics.compiler.setups import set_up, start_monitor
from scenic_lite.dynamics.compiler.watchers import conditions, limit_of, see_step, unsatisfied
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import COMPLETE
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.language.temporal import is_temporal
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value

DEFINING = (ast.FunctionDef, ast.Lambda, ast.ClassDef, nodes.Behavior, nodes.Scenario)


def main_part(c: Compilation) -> ScenarioInstance:
    """Return the program as a scenario: what loading it has made; its variables are those of its setup."""
    program, code = c.program, c.code
    main = program.main
    part = part_of(code, "scenario" if main is None else main.behavior.name, None, main)
    part.ego = c.state.ego
    if main is not None and program.main_frame is not None:
        loaded, behavior = program.main_frame, main.behavior
        inlined = InlinedBody((id(behavior.node),), Label(), behavior)
        assert loaded.outer is not None
        part.scope = CompiledScope(c, loaded.source, loaded.locals, loaded.outer, inlined)
        part.scope.assigned = behavior.assigned
    return part


# ------------------------------------------------------------ `do` of scenarios


def run_scenarios(c: Compilation, calls: list[Value], node: nodes.Do) -> None:
    """Begin all that are named, one after the other, then let each take a step at each time until all have ended."""
    code = c.code
    parts = [part for call in calls for part in begun(c, call, node)]
    again, end = Label(), Label()
    code.put_loop(again)
    for part in parts:
        with entered(c, part, node):
            step(c, part)
            show_names(part)
    on = Label()
    for part in parts:
        code.row(op.JUMP_IF, part.running, c=on)
    code.row(op.JUMP, c=end)
    code.put(on)
    suspend(c, again)
    code.put(end)


def begun(c: Compilation, call: Value, node: nodes.Do) -> list[ScenarioInstance]:
    """Write rows that begin a scenario, or whichever one it is in the match; return all that it can be."""
    if isinstance(call, BehaviorCall):
        return [begin(c, call, node)]
    assert isinstance(call, RandomChoice)
    parts: list[ScenarioInstance] = []
    cases = {i: lambda option=option: parts.append(begin(c, option, node)) for i, option in enumerate(call.options)}
    c.code.dispatch(register_of(c.code, call.index), cases)
    return parts


@contextmanager
def entered(c: Compilation, part: ScenarioInstance, node: nodes.Do) -> Iterator[None]:
    """Inside, a part is written at its place. Raises ScenicError for recursion."""
    assert part.call is not None and part.parent is not None
    with c.round(node, part.parent.parts.index(part)), c.entered(part.call.behavior, node):
        yield


def begin(c: Compilation, call: BehaviorCall, node: nodes.Do) -> ScenarioInstance:
    """Write rows that check the guards of a scenario, execute its setup, and start its time and its monitors."""
    code, parent = c.code, c.site.part
    assert parent is not None
    part = part_of(code, call.behavior.name, parent, call)
    part.ego = c.state.ego
    with entered(c, part, node):
        part.scope = frame_of(c, call)
        del part.scope.locals["self"]
        check_guards(c, part.scope)
        with c.within(part, setting_up=True):
            set_up(c, part)
        register_of(code, 1, part.running)
        start(c, part)
        show_names(part)
    if parent.ego is None:
        c.state.ego = part.ego
    return part


def show_names(part: ScenarioInstance) -> None:
    """Let others read the variables of a scenario as its attributes."""
    assert part.call is not None
    part.call.names.clear()
    part.call.names.update(part.scope.locals)


def start(c: Compilation, part: ScenarioInstance) -> None:
    """Begin what runs while the scenario does."""
    code = c.code
    assert part.call is not None
    if acts(part.call):
        code.row(op.SET_SLOT, part.slot, c=part.beginning)
    with c.within(part), code.statement():
        limit_of(c, part)
    for monitor in part.monitors:
        with c.within(part), code.statement():
            start_monitor(c, monitor)


def acts(call: BehaviorCall) -> bool:
    """Return whether a scenario has a compose block, or guards to watch over instead."""
    node = call.behavior.scenario
    return bool(node.compose or node.preconditions or node.invariants)


# ------------------------------------------------------------ a step


def step(c: Compilation, part: ScenarioInstance) -> None:
    """Write one step of a scenario: its requirements, its time limit, its compose block, its conditions."""
    code, done = c.code, Label()
    if part.parent is not None:
        code.row(op.JUMP_UNLESS, part.running, c=done)
    if may_require(c, part):
        part.call_routine(code, part.progress)
    take_time(c, part)
    with c.within(part, composing=True):
        if part.call is not None and acts(part.call):
            compose(c, part)
    with c.within(part):
        conditions(c, part, "scenario", lambda label: ended(c, part, label))
    code.row(op.JUMP, c=done)
    code.put(part.over)
    part.call_routine(code, part.stop)
    code.row(op.JUMP, c=done)
    code.put(part.kill)
    part.call_routine(code, part.stop)
    if part.parent is not None:
        code.row(op.JUMP, c=part.parent.kill)
    code.put(done)


def may_require(c: Compilation, part: ScenarioInstance) -> bool:
    """Return whether the scenario can have temporal requirements: written before, or in what is written later."""
    node = None if part.call is None else part.call.behavior.node
    trees = [] if node is None else [node]
    if part.parent is None:
        trees += [each.node for each in c.program.behaviors.values()]
    monitors = [each.call.behavior.node for each in part.monitors]
    every = (each for tree in (*trees, *monitors) for each in ast.walk(tree))
    return bool(part.temporal) or any(isinstance(each, nodes.Require) and is_temporal(each) for each in every)


def take_time(c: Compilation, part: ScenarioInstance) -> None:
    """Heed `terminate after`."""
    if part.limit is None:
        return
    code, (taken, allowed), going = c.code, part.limit, Label()
    code.row(op.JUMP_LESS, taken, allowed, going)
    ended(c, part, "reached time limit")
    code.put(going)
    code.row(op.ADD, taken, taken, code.constant(1))


def ended(c: Compilation, part: ScenarioInstance, reason: str) -> None:
    """End a scenario by itself; the end of the program's own is that of the match."""
    if part.parent is None:
        register_of(c.code, RegisterValue(c.reason(f"scenarioComplete: {reason}")), COMPLETE)
    c.code.row(op.JUMP, c=part.over)


def compose(c: Compilation, part: ScenarioInstance) -> None:
    """Let the compose block go on. Without one, guards are watched over while time passes."""
    code, scope = c.code, part.scope
    assert part.call is not None
    node = part.call.behavior.scenario
    code.row(op.RESUME, part.slot)
    code.put_reachable(part.beginning)
    with c.block(part.slot):
        if node.compose:
            scope.pin(watched_names(part))
            scope.run(node.compose)
            code.put(scope.inlined.end)
            ended(c, part, "finished compose block")
        else:
            pause(c)
            check_invariants(c, scope)
            code.row(op.JUMP, c=part.after)  # where its slot goes on next time is where it went on now
    code.put(part.after)


def watched_names(part: ScenarioInstance) -> frozenset[str]:
    """Return the variables that a compose block assigns and what watches the scenario may read."""
    assert part.call is not None
    node = part.call.behavior.scenario
    inside = [each for statement in node.compose for each in ast.walk(statement)]
    targets = {name.id for each in inside if isinstance(each, ast.For) for name in names_in(each.target)}
    changed = targets | assigned_names(*node.compose)
    watching = [each.watched.tree for each in (*part.terminations, *part.records)]
    watching += [each for statement in node.setup for each in ast.walk(statement) if isinstance(each, DEFINING)]
    return frozenset(changed & {name.id for tree in watching for name in names_in(tree)})


def names_in(tree: ast.AST) -> list[ast.Name]:
    return [each for each in ast.walk(tree) if isinstance(each, ast.Name)]


# ------------------------------------------------------------ routines


def write_routines(c: Compilation, main: ScenarioInstance) -> None:
    """Write how each scenario ends, and how its temporal requirements see a step."""
    code = c.code
    for part in main.family():
        code.place = None if part.call is None else part.call.place
        for label, write, title in (
            (part.progress, see_steps, "temporal requirements of"),
            (part.stop, stop, "end of"),
        ):
            if label.used:
                c.output.titles[label] = f"{title} {part.name}"
                code.reachable = True
                code.put(label)
                code.temporaries.used = code.temporaries.most  # others' intermediate results stay as they are
                with c.within(part):
                    write(c, part)
                code.row(op.RESUME, part.back)


def see_steps(c: Compilation, part: ScenarioInstance) -> None:
    for each in part.temporal:
        with c.code.statement():
            see_step(c, each)


def stop(c: Compilation, part: ScenarioInstance) -> None:
    """Stop what runs inside, give back what was overridden, reject the match if a requirement does not hold."""
    code, out = c.code, Label()
    code.row(op.JUMP_UNLESS, part.running, c=out)
    register_of(code, 0, part.running)
    if part.parent is not None:
        for monitor in part.monitors:
            register_of(code, 0, monitor.slot)
    for each in part.parts:
        each.call_routine(code, each.stop)
    for property_ in part.overridden.values():
        with code.when(property_.flag):
            with code.statement():
                property_.restore()
            register_of(code, 0, property_.flag)
    unsatisfied(c, part)
    if part.parent is not None:
        for register, value in part.resets:
            register_of(code, value, register)
    code.put(out)
