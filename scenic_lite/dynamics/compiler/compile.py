"""Compile the behaviors, monitors, end conditions and scenarios of a program to code for the virtual machine.

The main idea: **the compiler is the static evaluator, run with registers as leaves of its expression graph.** The code
that creates scenes also evaluates `distance from self to ball` for the compiler. The only difference is that `self.x`
is a register of the running match, so the graph becomes rows of the machine instead of columns of a scene. Arithmetic,
specifiers, operators and geometry are therefore implemented once. Only the following parts have separate code:

    statements, by jumps                                `statements`, `behaviors`, `interrupts`
    values with several options, conditions             `choices`, `expressions`
    lists whose length depends on the match             `lists`
    variables, by the type of their values              `types`, `registers`
    operations of the graph, one row each               `emit`
    nested scenarios                                    `scenarios`, `watchers`
    threads                                             below
    the arrays of a finished program                    `layout`

Behaviors and functions are inlined at their calls. A loop `best = None; for o in ...: best = o` reads a variable before
the compiler has seen all of its types. If a type changes after its use, another pass over the program follows.
Read next: `dynamics.compiler.statements`, the simplest part; `dynamics.machine.compiled`, which runs a match.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

from scenic_lite.core.budget import Budget
from scenic_lite.core.checks import FAULTS, as_error
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import COMPILE, Mode
from scenic_lite.core.types import BehaviorCall, Builtin, Environment, Namespace, ScenicClass
from scenic_lite.core.world import World
from scenic_lite.dynamics.compiler.behaviors import DYNAMIC, renew, run_behavior
from scenic_lite.dynamics.compiler.code import LABEL, Assembler, RuntimeDraw
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope, ScenarioInstance, Thread
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.expressions import EXPRESSIONS, call_value, dictionary, for_undecided
from scenic_lite.dynamics.compiler.interrupts import check_guards
from scenic_lite.dynamics.compiler.layout import finished
from scenic_lite.dynamics.compiler.registers import TypeTable
from scenic_lite.dynamics.compiler.scenarios import BEHAVIOR, NOBODY, SETTING_UP, check_first, main_part, step, stop
from scenic_lite.dynamics.compiler.statements import STATEMENTS
from scenic_lite.dynamics.compiler.watchers import ends_of_match, limit_of, record, see_steps
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import REWARD
from scenic_lite.dynamics.machine.compiled import Compiled
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.evaluation import calls
from scenic_lite.language.classes import OBJECT
from scenic_lite.scene.program import Program
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import ThetaColumn, Value

MAX_PASSES = 12


def compile_program(program: Program, world: World) -> Compiled:
    """Compile a program for a world. Raises ScenicError, with the place in the program, for unsupported code."""
    types = TypeTable()
    simulation = Namespace("simulation()", {}, open=True)
    for _ in range(MAX_PASSES):
        types.read, types.changed_types = set(), set()
        compilation = Compilation(program, world, Assembler(), types, simulation)
        compilation.mode = compile_mode(compilation)
        with live_objects(compilation):
            threads = compile_pass(compilation)
        if not types.changed_types:
            return finished(compilation, threads)
    raise ScenicError("budget", "the variables of the program's behaviors take their types from too many others")


@contextmanager
def live_objects(c: Compilation) -> Iterator[None]:
    """Allow live properties of objects inside the context; restore the loaded objects and variables afterwards."""
    instances = list(c.program.instances)
    loaded = [(instance.properties, instance.attributes) for instance in instances]
    for instance in instances:
        instance.properties, instance.attributes = dict(instance.properties), dict(instance.attributes)
    variables = {} if c.program.main_frame is None else c.program.main_frame.locals
    loaded_variables = dict(variables)
    try:
        yield
    finally:
        variables.clear()
        variables.update(loaded_variables)
        for instance, (properties, attributes) in zip(instances, loaded, strict=True):
            instance.properties, instance.attributes = properties, attributes


def compile_mode(c: Compilation) -> Mode:
    """Return the mode of the compiler, with a separate state for the statements of this pass."""
    loaded = c.program.mode
    own: dict[type, Any] = {kind: partial(handler, c) for kind, handler in EXPRESSIONS.items()}
    own |= {kind: partial(dictionary, loaded.handlers.expressions[kind]) for kind in (ast.Dict, ast.DictComp)}
    own[ast.Name] = partial(name, loaded.handlers.expressions[ast.Name])
    statements = {kind: with_location(c, handler) for kind, handler in (STATEMENTS | DYNAMIC | SETTING_UP).items()}
    simulation = Builtin("simulation", lambda: c.simulation, over_choices=False)

    def call(scope: Scope, function: Value, arguments: list, keywords: dict[str, Value], node: ast.AST) -> Value:
        return call_value(c, scope, function, arguments, keywords, node)

    handlers = replace(
        loaded.handlers,
        expressions=loaded.handlers.expressions | own | {nodes.New: partial(new, c)},
        statements=loaded.handlers.statements | statements,
        call=call,
        undecided=partial(for_undecided, c),
        builtins=loaded.handlers.builtins | {"simulation": simulation},
    )
    state = loaded.state.copy_to_play()
    return Mode(COMPILE, state, handlers, Budget(state.budget.limits), partial(draw, c), symbolic=True)


def name(handler: Callable[[Scope, ast.Name], Value], scope: Scope, node: ast.Name) -> Value:
    """Return the value of a name; a match in which the name has no value yet stops."""
    at: Environment | None = scope
    while at is not None and node.id not in at.locals and not (isinstance(at, CompiledScope) and node.id in at.unset):
        at = at.outer
    if isinstance(at, CompiledScope) and node.id in at.unset:
        at.check_set(node.id)
    return dictionary(handler, scope, node)


def draw(c: Compilation, kind: str, place: SourceSpan, offset: float, span: float) -> ThetaColumn:
    """Write a draw from the match's random stream at the present point of the program."""
    code = c.code
    register = code.temporaries.take()
    code.row(op.DRAW, register, code.constant(offset), code.constant(span))
    return RuntimeDraw(register, kind, place, offset, span)


def new(c: Compilation, scope: Scope, node: nodes.New) -> Value:
    """Create a point in a behavior; Objects must be created before the match."""
    cls = scope.value(node.cls)
    if isinstance(cls, ScenicClass) and cls.derives_from(OBJECT):
        if c.site.setting_up:
            message = "objects that a scenario makes while a match runs are played by the reference only"
            raise ScenicError("unsupported", message, hint="make them in the main scenario")
        hint = "make it before, or in the setup of a scenario"
        raise ScenicError("type", "no object can be made in a behavior", hint=hint)
    return calls.new(scope, node)


def with_location(
    compilation: Compilation, handler: Callable[[Compilation, CompiledScope, Any], None]
) -> Callable[[CompiledScope, Any], None]:
    """Return a statement handler that records the place of its rows.

    A statement with an error (an unknown name, a moving region) stops a match that reaches it, as in the reference
    interpreter. A program with unsupported code is rejected as a whole.
    """

    def handle(scope: CompiledScope, node: ast.stmt) -> None:
        code = compilation.code
        before, code.place = code.place, scope.place(node)
        start, known, begun = len(code.rows), len(compilation.output.diagnostics), compilation.scenarios_begun()
        try:
            with code.statement():
                handler(compilation, scope, node)
        except FAULTS as fault:
            error = scope.placed(as_error(fault), node)
            if error.kind in REFUSALS:
                raise
            error = compilation.seen_from_calls(error)
            inner = [error for error in compilation.output.diagnostics[known:] if error.kind != "warning"]
            if inner and not code.reachable:  # unreachable, since an earlier call has failed
                error = inner[0]
            else:
                compilation.output.diagnostics.append(error)
            del code.rows[start:]
            compilation.forget_scenarios(begun)
            code.reachable = True
            compilation.stop_with(error)
        finally:
            code.place = before

    return handle


REFUSALS = frozenset({"unsupported", "budget", "syntax", "import"})


# ------------------------------------------------------------ the threads of a match
def compile_pass(c: Compilation) -> list[Thread]:
    """Compile the whole program once and return the threads."""
    code = c.code
    code.row(op.END, code.fixed.take())  # row 0 is the entry of a thread that has ended
    show_world(c)
    for key in [key for key in c.types.types if key[0] == "object"]:  # attributes that earlier passes saw assigned
        c.table_of(key)[key[2]] = c.shared_variable(key).load()
    main = main_part(c)
    agents = [Thread(f"{instance.title()}: its behavior", 0, agent=instance) for instance in c.program.instances]
    for thread in agents:
        assert thread.agent is not None
        thread.call = thread.agent.properties["behavior"]
    scenarios: list[Thread] = []
    every(c, scenarios, "start", partial(start, c, main, agents), once=True)
    every(c, scenarios, f"scenario {main.name}" if main.call else main.name, partial(step, c, main), needed=True)
    every(c, scenarios, "record initial", partial(record, c, main, "initial"), once=True)
    records: list[Thread] = []
    every(c, records, "record", partial(record, c, main, "each"))
    behaviors = behavior_threads(c, main, agents)
    monitors: list[Thread] = []
    for part in main.family():
        for monitor in part.monitors:
            write_body(c, monitor, part)
            monitors.append(monitor)
    ends: list[Thread] = []
    every(c, ends, "terminate simulation when", partial(ends_of_match, c, main), needed=True)
    every(c, ends, "at the end", partial(end_all, c, main), needed=True)
    last = [each for each in c.output.records if each.when == "final"]
    c.output.records = [each for each in c.output.records if each.when != "final"]
    write_routines(c, main)
    c.output.records += last  # among records with one name, the program's own takes precedence
    c.output.counts = (len(scenarios), len(behaviors), len(records), len(monitors))
    return [*scenarios, *behaviors, *records, *monitors, *ends]


def start(c: Compilation, main: ScenarioInstance, agents: list[Thread]) -> None:
    """Write the start of a match: check the guards of the main scenario, behaviors and monitors; set the time limit."""
    with c.within(main):
        if main.scope is not None:
            check_guards(c, main.scope)
        limit_of(c, main)
        for thread in (*agents, *main.monitors):
            if isinstance(thread.call, BehaviorCall):
                c.code.place = thread.call.place
                check_first(c, thread)


def behavior_threads(c: Compilation, main: ScenarioInstance, agents: list[Thread]) -> list[Thread]:
    """Return the threads of the objects, in the order of the objects."""
    threads: list[Thread] = []
    movers = [mover.agent for mover in agents if mover.agent and (mover.call or mover.agent.label in c.overrides)]
    if c.remembering and c.program.dialect == 3:
        every(c, threads, "lastActions", partial(renew, c, movers))
    for thread in agents:
        assert thread.agent is not None
        if thread.agent.label in c.overrides:
            write_overridden(c, thread, c.overrides[thread.agent.label], main)
        elif isinstance(thread.call, BehaviorCall):
            thread.title, thread.slot = f"{thread.agent.title()}: {thread.call.behavior.name}", c.code.fixed.take()
            write_body(c, thread, main)
        else:
            continue
        threads.append(thread)
        c.output.starting[thread.slot] = thread.entry
    if c.remembering and c.program.dialect == 2:
        every(c, threads, "lastActions", partial(renew, c, movers))
    return threads


def write_overridden(c: Compilation, thread: Thread, overrides: list[Thread], main: ScenarioInstance) -> None:
    """Write the thread of an object whose behavior can change; the thread resumes the present behavior."""
    code, agent, call = c.code, thread.agent, thread.call
    assert agent is not None
    register = register_of(code, c.shared_variable(("object", agent.label, BEHAVIOR)).load())
    c.output.overridden.append((c.program.instances.index(agent), register, call is not None))
    if call is not None:
        first = Thread(f"{agent.title()}: {call.behavior.name}", code.fixed.take(), call, agent)
        c.output.starting[first.slot] = first.entry
        overrides = [first, *overrides]
    thread.slot = code.fixed.take()
    begin(c, thread)
    code.dispatch(register, {override.number: partial(code.row, op.RESUME, override.slot) for override in overrides})
    code.row(op.WAIT, 0, thread.slot, thread.entry)
    for override in overrides:
        c.output.titles[override.entry] = override.title
        write_body(c, override, main)


def end_all(c: Compilation, main: ScenarioInstance) -> None:
    """Write the end of a match: check for unsatisfied requirements, and take final records."""
    if main.temporal or main.parts:
        main.call_stop(c.code)
    record(c, main, "final")


def write_routines(c: Compilation, main: ScenarioInstance) -> None:
    """Write the `stop` routine of each scenario, and insert its temporal requirements at the start of its step."""
    code = c.code
    for part in main.family():
        code.place = None if part.call is None else part.call.place
        code.reachable = True
        code.temporaries.used = code.temporaries.most  # do not overwrite intermediate results of callers
        with c.within(part):
            with code.captured() as rows:
                see_steps(c, part)
            at = next(i for i, row in enumerate(code.rows) if row.c is part.progress)
            code.rows[at:at] = rows
            if part.stop.used:
                c.output.titles[part.stop] = f"end of {part.name}"
                code.put(part.stop)
                stop(c, part)
                code.row(op.RESUME, part.back)


# ------------------------------------------------------------ the state of a match
def show_world(c: Compilation) -> None:
    """Set the live properties of the objects and the value of `simulation()`."""
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
            code.register_names[first + i] = f"{instance.title()}.{name}"
        live = world.properties(instance, fields)
        names |= set(live)
        instance.properties.update(live)
        instance.properties["lastActions"] = ()
        instance.attributes[BEHAVIOR] = NOBODY if instance.properties["behavior"] is None else 0
    for i, name in enumerate(world.facts):
        code.register_names[c.shown.facts + i] = name
    c.shown.names = frozenset(names)
    if not c.simulation.names:  # once: all passes use the same registers, and variables hold parts of the world
        c.simulation.names.update(world.simulation(list(program.instances), dict(facts)).names)
        c.simulation.names["scenic_reward"] = RegisterValue(REWARD)


# ------------------------------------------------------------ one thread
def every(
    c: Compilation,
    threads: list[Thread],
    title: str,
    write: Callable[[], object],
    once: bool = False,
    needed: bool = False,
) -> None:
    """Write a thread that runs from its start in every step, or only once; an empty thread is omitted unless needed."""
    code, first = c.code, len(c.code.rows)
    thread = Thread(title, code.fixed.take())
    begin(c, thread)
    with code.statement():
        write()
    if not needed and all(row.opcode == LABEL for row in code.rows[first:]):
        del code.rows[first:]
        return
    if once:
        code.row(op.END, thread.slot)
    else:
        code.row(op.WAIT, 0, thread.slot, thread.entry)
    threads.append(thread)
    c.output.starting[thread.slot] = thread.entry


def begin(c: Compilation, thread: Thread) -> None:
    """Begin a thread at the next row, with separate variables."""
    code = c.code
    code.variables.used = code.variables.most
    code.place = None
    code.put_reachable(thread.entry)


def write_body(c: Compilation, thread: Thread, part: ScenarioInstance) -> None:
    """Write the rows of a behavior or monitor."""
    call = thread.call
    assert call is not None
    begin(c, thread)
    c.code.place = call.place
    owner = None if thread.agent is None else thread.agent.label
    with (
        c.within(part, agent=thread.agent, slot=thread.slot),
        c.round(call.behavior.node, owner, thread.number),
        c.code.statement(),
    ):
        run_behavior(c, call, call.behavior.node, guards=False)
    c.code.row(op.END, thread.slot)
