"""Compile the behaviors, monitors and conditions of a program into code for the machine (`vm`).

The program's trees are walked by the evaluator of the static half, with the numbers of the match as leaves of its
graph; what statements do becomes rows. The walk is repeated until no variable's shape widens, then the areas of
registers are laid side by side. Read next: `dynamics.compiler.compilation`; `dynamics.machine.compiled`, which plays
a match.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

from scenic_lite.core.budget import Budget
from scenic_lite.core.checks import RuntimeChecks
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import COMPILE, Mode
from scenic_lite.core.types import BehaviorCall, Builtin, Instance, Namespace, ScenicClass, describe_kind
from scenic_lite.core.world import World
from scenic_lite.dynamics.compiler.behaviors import DYNAMIC, forget, reveal, run_behavior
from scenic_lite.dynamics.compiler.code import Assembler, DrawnNow, Label
from scenic_lite.dynamics.compiler.compilation import Compilation, with_location
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.expressions import EXPRESSIONS, call_value, dictionary
from scenic_lite.dynamics.compiler.layout import Thread, finished
from scenic_lite.dynamics.compiler.parts import BehaviorOverride, ScenarioInstance, Temporal, WatchedItem
from scenic_lite.dynamics.compiler.registers import TypeTable
from scenic_lite.dynamics.compiler.scenarios import acts, main_part, may_require, step, write_routines
from scenic_lite.dynamics.compiler.setups import SETTING_UP, monitor_of
from scenic_lite.dynamics.compiler.statements import STATEMENTS
from scenic_lite.dynamics.compiler.watchers import Automaton, ends_of_match, forget_records, record, start
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import REWARD, TERMINATED
from scenic_lite.dynamics.machine.compiled import Compiled
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.evaluation.calls import meaning
from scenic_lite.language.classes import OBJECT
from scenic_lite.language.specifiers import make
from scenic_lite.language.temporal import formula_of
from scenic_lite.scene.program import Program
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import ThetaColumn, Value

MOST_WALKS = 12


def compile_program(program: Program, world: World) -> Compiled:
    """The code of a program in a world. Raises ScenicError, with its place, for what cannot be compiled."""
    types = TypeTable()
    simulation = Namespace("simulation()", {}, open=True)
    modules: dict[int, dict[str, Value]] = {}
    for _ in range(MOST_WALKS):
        types.begin_walk()
        compilation = Compilation(program, world, Assembler(), types, simulation, modules)
        compilation.mode = compile_mode(compilation)
        with live_objects(compilation):
            threads = walk(compilation)
        if not types.outdated:
            return finished(compilation, threads)
    raise ScenicError("budget", "the variables of the program's behaviors take their types from too many others")


@contextmanager
def live_objects(c: Compilation) -> Iterator[None]:
    """Inside, objects have live properties; outside, they and all variables are as they were loaded."""
    instances = list(c.program.instances)
    loaded = [(each.properties, each.attributes) for each in instances]
    for each in instances:
        each.properties, each.attributes = dict(each.properties), dict(each.attributes)
    variables = {} if c.program.main_frame is None else c.program.main_frame.locals
    loaded_variables = dict(variables)
    try:
        yield
    finally:
        variables.clear()
        variables.update(loaded_variables)
        for each, (properties, attributes) in zip(instances, loaded, strict=True):
            each.properties, each.attributes = properties, attributes
        for number, before in c.before.items():
            c.modules[number].update(before)


def compile_mode(c: Compilation) -> Mode:
    """Return how nodes are evaluated while a program is compiled; what statements make is the walk's own."""
    loaded = c.program.mode
    own: dict[type, Any] = {kind: partial(handler, c) for kind, handler in EXPRESSIONS.items()}
    own |= {kind: partial(dictionary, loaded.handlers.expressions[kind]) for kind in (ast.Dict, ast.DictComp, ast.Name)}
    statements = {kind: with_location(c, handler) for kind, handler in (STATEMENTS | DYNAMIC | SETTING_UP).items()}
    simulation = Builtin("simulation", lambda: c.simulation, over_choices=False)

    def call(scope: Scope, function: Value, arguments: list, keywords: dict[str, Value], node: ast.AST) -> Value:
        return call_value(c, scope, function, arguments, keywords, node)

    handlers = replace(
        loaded.handlers,
        expressions=loaded.handlers.expressions | own | {nodes.New: partial(new, c)},
        statements=loaded.handlers.statements | statements,
        call=call,
        builtins=loaded.handlers.builtins | {"simulation": simulation},
    )
    state = replace(
        loaded.state,
        points=[],
        requirements=[],
        scenarios=list(loaded.state.scenarios),
        behaviors=dict(loaded.state.behaviors),
        watching=RuntimeChecks(),
    )
    state.forget_watched()
    return Mode(COMPILE, state, handlers, Budget(state.budget.limits), partial(draw, c), symbolic=True)


def draw(c: Compilation, kind: str, place: SourceSpan, offset: float, span: float) -> ThetaColumn:
    """A number from the match's stream, drawn where the program is now."""
    code = c.code
    register = code.temporaries.take()
    code.row(op.DRAW, register, code.constant(offset), code.constant(span))
    return DrawnNow(register, kind, place, offset, span)


def new(c: Compilation, scope: Scope, node: nodes.New) -> Value:
    """A point that a behavior speaks of; objects are made before the match."""
    cls = scope.value(node.cls)
    if not isinstance(cls, ScenicClass):
        if not node.certain:
            return cls if node.operator is None else scope.value(node.operator)
        raise scope.error("type", f"{describe_kind(cls)} is no class to make an object of", node.cls)
    if cls.derives_from(OBJECT):
        if c.setting_up:
            message = "objects that a scenario makes while a match runs are played by the reference only"
            raise ScenicError("unsupported", message, hint="make them in the main scenario")
        hint = "make it before, or in the setup of a scenario"
        raise ScenicError("type", "no object can be made in a behavior", hint=hint)
    instance = Instance(cls, scope.place(node))
    return make(scope, cls, [meaning(scope, instance, each) for each in node.specifiers], instance)


# ------------------------------------------------------------ one walk


def walk(c: Compilation) -> list[Thread]:
    """Compile everything once; the threads: slot, object, entry, title."""
    code = c.code
    code.row(op.END, code.fixed.take())  # row 0: where a thread stands that has ended
    code.reachable = False
    show_world(c)
    threads: list[Thread] = []
    c.show_shared()
    main = main_part(c)
    import_loaded(c, main)
    scenarios = scenario_threads(c, threads, main)
    recorders: list[Thread] = []
    records = record_threads(c, recorders, main)
    behaviors = behavior_threads(c, threads, main)
    threads += recorders
    monitors = monitor_threads(c, threads, main)
    c.counts = (scenarios, behaviors, records, monitors)
    every(c, threads, "terminate simulation when", lambda: ends_of_match(c, main))
    every(c, threads, "at the end", lambda: end_all(c, main))
    write_routines(c, main)
    return threads


def import_loaded(c: Compilation, main: ScenarioInstance) -> None:
    """Take over what loading the program has made."""
    program = c.program
    main.monitors = [monitor_of(c, call, None) for call in program.monitors]
    main.terminations = [WatchedItem(each) for each in program.terminations]
    main.records = [WatchedItem(each) for each in program.records]
    for each in program.temporal:
        state = c.code.fixed.take()
        main.temporal.append(Temporal(each, None, Automaton(formula_of(each.tree.condition)), state))
    for monitor in main.monitors:
        c.starting[monitor.slot] = monitor.entry
    c.starting[main.slot] = main.beginning


def scenario_threads(c: Compilation, threads: list[Thread], main: ScenarioInstance) -> int:
    """The threads that run first at each time: what begins the match, the scenarios, what is recorded first."""
    guards: list[tuple[Instance | None, BehaviorCall]] = [(agent, call) for _, agent, call in agents_of(c)]
    guards += [(None, each.call) for each in main.monitors]
    has_limit = any(isinstance(each.watched.tree, nodes.TerminateAfter) for each in main.terminations)
    if has_limit or any(map(has_guards, [call for _, call in guards])) or (main.call and has_guards(main.call)):
        with c.within(main):
            every(c, threads, "start", lambda: start(c, main, guards), once=True)
    if main.terminations or may_require(c, main) or (main.call and acts(main.call)):
        every(c, threads, f"scenario {main.name}" if main.call else main.name, lambda: step(c, main))
    if any(each.watched.tree.when == "initial" for part in main.family() for each in part.records):
        every(c, threads, "record initial", lambda: record(c, main, "initial"), once=True)
    return len(threads)


def behavior_threads(c: Compilation, threads: list[Thread], main: ScenarioInstance) -> int:
    """The threads of the objects, in their order."""
    before = len(threads)
    if any(each.when == "each" for each in c.records):
        every(c, threads, "a new step for records", lambda: forget_records(c))
    things = c.program.instances
    movers = [each for each in things if each.properties["behavior"] is not None or each.label in c.drivers]
    if c.remembering and c.program.dialect == 3:
        every(c, threads, "lastActions", lambda: forget(c, movers))
    for number, agent in enumerate(c.program.instances):
        call = agent.properties["behavior"]
        if agent.label in c.drivers:
            with c.within(main):
                driven(c, threads, number, agent, call)
        elif isinstance(call, BehaviorCall):
            c.agent = agent
            with c.within(main):
                body(c, threads, number, call, f"{agent.title()}: {call.behavior.name}")
    c.agent = None
    if c.remembering and c.program.dialect == 2:
        every(c, threads, "lastActions", lambda: reveal(c, movers))
    return len(threads) - before


def driven(c: Compilation, threads: list[Thread], number: int, agent: Instance, call: BehaviorCall | None) -> None:
    """The thread of an object whose behavior changes: it goes on where the one that it has now says."""
    code, slot, entry = c.code, c.code.fixed.take(), Label()
    register = c.driving[agent.label]
    drivers = list(c.drivers[agent.label])
    if call is not None:
        first = BehaviorOverride(agent, call, code.fixed.take(), Label(), 0, None)
        c.starting[first.slot] = first.entry
        drivers.insert(0, first)
    begin(code, entry)
    for each in drivers:
        other = Label()
        code.row(op.JUMP_NOT_EQUAL, register, code.constant(each.number), other)
        code.row(op.RESUME, each.slot)
        code.put(other)
    code.row(op.WAIT, 0, slot, entry)
    code.reachable = False
    threads.append((slot, number, entry, f"{agent.title()}: its behavior"))
    c.starting[slot] = entry
    c.agent = agent
    for each in drivers:
        where = "" if each.part is None else f" (override in {each.part.name})"
        c.titles[each.entry] = f"{agent.title()}: {each.call.behavior.name}{where}"
        write_body(c, each.slot, each.entry, each.call, (number, each.number))


def record_threads(c: Compilation, threads: list[Thread], main: ScenarioInstance) -> int:
    before = len(threads)
    if any(each.watched.tree.when == "each" for part in main.family() for each in part.records):
        every(c, threads, "record", lambda: record(c, main, "each"))
    return len(threads) - before


def monitor_threads(c: Compilation, threads: list[Thread], main: ScenarioInstance) -> int:
    """Those of a scenario, those of the scenarios inside it, then its end if one of its own has asked for it."""
    before = len(threads)
    monitors_of(c, threads, main)
    return len(threads) - before


def monitors_of(c: Compilation, threads: list[Thread], part: ScenarioInstance) -> None:
    where = "" if part.parent is None else f" of {part.name}"
    ending = any(ends_scenario(each.call) for each in part.monitors)
    before = c.code.fixed.take()
    if ending:
        every(c, threads, f"before the monitors{where}", lambda: save_end_flags(c, before))
    for monitor in part.monitors:
        title = f"monitor {monitor.call.behavior.name}{where}"
        with c.within(part):
            write_body(c, monitor.slot, monitor.entry, monitor.call, (-1, len(threads)))
        threads.append((monitor.slot, -1, monitor.entry, title))
    for each in part.parts:
        monitors_of(c, threads, each)
    if ending:
        every(c, threads, f"after the monitors{where}", lambda: end_asked_for(c, part, before))


def ends_scenario(call: BehaviorCall) -> bool:
    return any(isinstance(each, nodes.Terminate) for each in ast.walk(call.behavior.node))


def save_end_flags(c: Compilation, before: int) -> None:
    """What others have asked for so far, to see whether a monitor of a scenario or inside it asks for an end."""
    register_of(c.code, RegisterValue(TERMINATED), before)
    register_of(c.code, 0, TERMINATED)


def end_asked_for(c: Compilation, part: ScenarioInstance, before: int) -> None:
    """What a monitor's `terminate` does when all have run: any other end that was asked for inside counts more."""
    code, out, none, known = c.code, Label(), Label(), Label()
    code.row(op.JUMP_UNLESS, part.ending, c=none)
    if part.parent is not None:
        part.call_routine(code, part.stop)
    code.row(op.JUMP_IF, TERMINATED, c=out)
    register_of(code, RegisterValue(part.ending), TERMINATED)
    code.row(op.JUMP, c=out)
    code.put(none)
    code.row(op.JUMP_IF, TERMINATED, c=known)
    register_of(code, RegisterValue(before), TERMINATED)
    code.put(known)
    code.put(out)


def end_all(c: Compilation, main: ScenarioInstance) -> None:
    """The match is over: what it leaves unsatisfied, and what is recorded last."""
    if main.temporal or main.parts:
        main.call_routine(c.code, main.stop)
    record(c, main, "final")


def agents_of(c: Compilation) -> list[tuple[int, Instance, BehaviorCall]]:
    """The behaviors that objects begin with."""
    found = []
    for number, instance in enumerate(c.program.instances):
        call = instance.properties["behavior"]
        if isinstance(call, BehaviorCall):
            found.append((number, instance, call))
    return found


def has_guards(call: BehaviorCall) -> bool:
    return bool(call.behavior.node.preconditions or call.behavior.node.invariants)


def show_world(c: Compilation) -> None:
    """Give the objects their live properties and `simulation()` its meaning."""
    world, program, code = c.world, c.program, c.code
    c.remembering = any(
        "lastActions" in line for source in program.mode.state.sources.values() for line in source.lines
    )
    c.world_base = code.fixed.take(len(program.instances) * len(world.fields))
    c.fact_base = code.fixed.take(len(world.facts))
    facts = {name: RegisterValue(c.fact_base + i, whole=name == "time") for i, name in enumerate(world.facts)}
    c.clock = facts.get("time")
    names: set[str] = set()
    for number, instance in enumerate(program.instances):
        first = c.world_base + number * len(world.fields)
        fields: dict[str, Value] = {}
        for i, name in enumerate(world.fields):
            fields[name] = RegisterValue(first + i)
            code.notes[first + i] = f"{instance.title()}.{name}"
        live = world.properties(instance, fields)
        names |= set(live)
        instance.properties.update(live)
        instance.properties["lastActions"] = ()
    for i, name in enumerate(world.facts):
        code.notes[c.fact_base + i] = name
    c.live_names = frozenset(names)
    seen = world.simulation(list(program.instances), dict(facts))
    update(c.simulation, seen)
    c.simulation.names["scenic_reward"] = RegisterValue(REWARD)


def update(old: Namespace, new: Namespace) -> None:
    """Let a namespace that variables hold since an earlier walk show this one's registers."""
    inner = {name: value for name, value in old.names.items() if isinstance(value, Namespace)}
    old.names.clear()
    old.names.update(new.names)
    for name, value in inner.items():
        if isinstance(new.names.get(name), Namespace):
            old.names[name] = value
            update(value, new.names[name])


def every(c: Compilation, threads: list[Thread], title: str, write: Callable[[], object], once: bool = False) -> None:
    """A thread that runs from its beginning in every step, or once."""
    code = c.code
    slot, entry = code.fixed.take(), Label()
    begin(code, entry)
    with code.statement():
        write()
    if once:
        code.row(op.END, slot)
    else:
        code.row(op.WAIT, 0, slot, entry)
    code.reachable = False
    threads.append((slot, -1, entry, title))
    c.starting[slot] = entry


def begin(code: Assembler, entry: Label) -> None:
    """A thread starts here; its variables are its own."""
    code.variables.used = code.variables.most
    code.place = None
    code.reachable = True
    entry.used = True
    code.put_loop(entry)


def body(c: Compilation, threads: list[Thread], number: int, call: BehaviorCall, title: str) -> None:
    """The thread of a behavior."""
    slot, entry = c.code.fixed.take(), Label()
    write_body(c, slot, entry, call, (number, 0))
    threads.append((slot, number, entry, title))
    c.starting[slot] = entry


def write_body(c: Compilation, slot: int, entry: Label, call: BehaviorCall, key: tuple[int, int]) -> None:
    """The rows of a behavior or monitor whose outermost block has this slot."""
    code = c.code
    begin(code, entry)
    code.place = call.place
    with code.statement(), c.block(slot), c.round(call.behavior.node, key[0]), c.rounds(key[1]):
        run_behavior(c, call, call.behavior.node, guards=False)
    code.row(op.END, slot)
    code.reachable = False
