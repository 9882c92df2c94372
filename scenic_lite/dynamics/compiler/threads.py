"""The threads of a match, in the order in which they run at each time: scenarios, behaviors, records, monitors, ends.

A thread is a slot, which says at which row it goes on, the object that it moves, and its first row. Read next:
`dynamics.compiler.layout`, which makes arrays of what is written here.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenic_lite.core.types import BehaviorCall, Instance, Namespace
from scenic_lite.dynamics.compiler.behaviors import forget, reveal, run_behavior
from scenic_lite.dynamics.compiler.code import Assembler, Label
from scenic_lite.dynamics.compiler.compilation import Compilation
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.layout import Thread
from scenic_lite.dynamics.compiler.parts import BehaviorOverride, ScenarioInstance, Temporal, WatchedItem
from scenic_lite.dynamics.compiler.scenarios import acts, main_part, may_require, step, write_routines
from scenic_lite.dynamics.compiler.setups import monitor_of
from scenic_lite.dynamics.compiler.watchers import Automaton, ends_of_match, forget_records, record, start
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import REWARD, TERMINATED
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.language.temporal import formula_of
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value


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
    c.output.counts = (scenarios, behaviors, records, monitors)
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
        c.output.starting[monitor.slot] = monitor.entry
    c.output.starting[main.slot] = main.beginning


def scenario_threads(c: Compilation, threads: list[Thread], main: ScenarioInstance) -> int:
    """Return the threads that run first at each time: what begins the match, the scenarios, what is recorded first."""
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
    """Return the threads of the objects, in their order."""
    before = len(threads)
    if any(each.when == "each" for each in c.output.records):
        every(c, threads, "a new step for records", lambda: forget_records(c))
    things = c.program.instances
    movers = [each for each in things if each.properties["behavior"] is not None or each.label in c.overrides.behaviors]
    if c.remembering and c.program.dialect == 3:
        every(c, threads, "lastActions", lambda: forget(c, movers))
    for number, agent in enumerate(c.program.instances):
        call = agent.properties["behavior"]
        if agent.label in c.overrides.behaviors:
            with c.within(main):
                driven(c, threads, number, agent, call)
        elif isinstance(call, BehaviorCall):
            with c.within(main), c.acting(agent):
                body(c, threads, number, call, f"{agent.title()}: {call.behavior.name}")
    if c.remembering and c.program.dialect == 2:
        every(c, threads, "lastActions", lambda: reveal(c, movers))
    return len(threads) - before


def driven(c: Compilation, threads: list[Thread], number: int, agent: Instance, call: BehaviorCall | None) -> None:
    """Write the thread of an object whose behavior changes: it goes on where the one that it has now says."""
    code, slot, entry = c.code, c.code.fixed.take(), Label()
    register = c.overrides.registers[agent.label]
    drivers = list(c.overrides.behaviors[agent.label])
    if call is not None:
        first = BehaviorOverride(agent, call, code.fixed.take(), Label(), 0, None)
        c.output.starting[first.slot] = first.entry
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
    c.output.starting[slot] = entry
    for each in drivers:
        where = "" if each.part is None else f" (override in {each.part.name})"
        c.output.titles[each.entry] = f"{agent.title()}: {each.call.behavior.name}{where}"
        with c.acting(agent):
            write_body(c, each.slot, each.entry, each.call, (number, each.number))


def record_threads(c: Compilation, threads: list[Thread], main: ScenarioInstance) -> int:
    before = len(threads)
    if any(each.watched.tree.when == "each" for part in main.family() for each in part.records):
        every(c, threads, "record", lambda: record(c, main, "each"))
    return len(threads) - before


def monitor_threads(c: Compilation, threads: list[Thread], main: ScenarioInstance) -> int:
    """Return those of a scenario, those of the scenarios inside it, then its end if one of its own has asked for it."""
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
    """Save what others have asked for so far, to see whether a monitor of a scenario or inside it asks for an end."""
    register_of(c.code, RegisterValue(TERMINATED), before)
    register_of(c.code, 0, TERMINATED)


def end_asked_for(c: Compilation, part: ScenarioInstance, before: int) -> None:
    """Do what a monitor's `terminate` asks when all have run: any other end that was asked for inside counts more."""
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
    """Write what happens when a match is over: what it leaves unsatisfied, and what is recorded last."""
    if main.temporal or main.parts:
        main.call_routine(c.code, main.stop)
    record(c, main, "final")


def agents_of(c: Compilation) -> list[tuple[int, Instance, BehaviorCall]]:
    """Return the behaviors that objects begin with."""
    agents = []
    for number, instance in enumerate(c.program.instances):
        call = instance.properties["behavior"]
        if isinstance(call, BehaviorCall):
            agents.append((number, instance, call))
    return agents


def has_guards(call: BehaviorCall) -> bool:
    return bool(call.behavior.node.preconditions or call.behavior.node.invariants)


def show_world(c: Compilation) -> None:
    """Give the objects their live properties and `simulation()` its meaning."""
    world, program, code = c.world, c.program, c.code
    c.remembering = any(
        "lastActions" in line for source in program.mode.state.sources.values() for line in source.lines
    )
    c.shown.base = code.fixed.take(len(program.instances) * len(world.fields))
    c.shown.facts = code.fixed.take(len(world.facts))
    facts = {name: RegisterValue(c.shown.facts + i, whole=name == "time") for i, name in enumerate(world.facts)}
    c.shown.clock = facts.get("time")
    names: set[str] = set()
    for number, instance in enumerate(program.instances):
        first = c.shown.base + number * len(world.fields)
        fields: dict[str, Value] = {}
        for i, name in enumerate(world.fields):
            fields[name] = RegisterValue(first + i)
            code.notes[first + i] = f"{instance.title()}.{name}"
        live = world.properties(instance, fields)
        names |= set(live)
        instance.properties.update(live)
        instance.properties["lastActions"] = ()
    for i, name in enumerate(world.facts):
        code.notes[c.shown.facts + i] = name
    c.shown.names = frozenset(names)
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
    """Write a thread that runs from its beginning in every step, or once."""
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
    c.output.starting[slot] = entry


def begin(code: Assembler, entry: Label) -> None:
    """Begin a thread here; its variables are its own."""
    code.variables.used = code.variables.most
    code.place = None
    code.reachable = True
    entry.used = True
    code.put_loop(entry)


def body(c: Compilation, threads: list[Thread], number: int, call: BehaviorCall, title: str) -> None:
    """Write the thread of a behavior."""
    slot, entry = c.code.fixed.take(), Label()
    write_body(c, slot, entry, call, (number, 0))
    threads.append((slot, number, entry, title))
    c.output.starting[slot] = entry


def write_body(c: Compilation, slot: int, entry: Label, call: BehaviorCall, key: tuple[int, int]) -> None:
    """Write the rows of a behavior or monitor whose outermost block has this slot."""
    code = c.code
    begin(code, entry)
    code.place = call.place
    with code.statement(), c.block(slot), c.round(call.behavior.node, key[0]), c.numbered(key[1]):
        run_behavior(c, call, call.behavior.node, guards=False)
    code.row(op.END, slot)
    code.reachable = False
