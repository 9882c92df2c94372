"""Compile the behaviors, monitors and conditions of a program into code for the machine (`vm`).

The program's trees are walked by the evaluator of the static half, with the numbers of the match as leaves of its
graph; what statements do becomes rows. The walk is repeated until no variable's shape widens, then the areas of
registers are laid side by side. Read next: `compiler_frame`; `compiled`, which plays a match.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from scenic_lite.budget import Budget
from scenic_lite.classes import OBJECT
from scenic_lite.dynamics.bytecode import REWARD, Op
from scenic_lite.dynamics.compiled import Compiled
from scenic_lite.dynamics.compiler.attributes import forget, reveal, show_shared
from scenic_lite.dynamics.compiler.behaviors import DYNAMIC, run_behavior
from scenic_lite.dynamics.compiler.calls import call_node, call_value
from scenic_lite.dynamics.compiler.choices import attribute_of, binary, formatted, scenic_operator, subscript, unary
from scenic_lite.dynamics.compiler.code import Assembler, DrawnNow, Label, Live
from scenic_lite.dynamics.compiler.comprehensions import comprehension, dictionary_comprehension
from scenic_lite.dynamics.compiler.conditions import boolean, comparison, conditional
from scenic_lite.dynamics.compiler.frame import Compilation, guarded
from scenic_lite.dynamics.compiler.layout import finished
from scenic_lite.dynamics.compiler.shapes import Shape
from scenic_lite.dynamics.compiler.statements import STATEMENTS
from scenic_lite.dynamics.compiler.watchers import conditions, ends_of_scenario, start, temporal, unsatisfied
from scenic_lite.dynamics.world import World
from scenic_lite.errors import Place, ScenicError
from scenic_lite.evaluation.calls import meaning
from scenic_lite.evaluation.frame import Frame
from scenic_lite.graph import Column, Value
from scenic_lite.program import Program
from scenic_lite.specifiers import make
from scenic_lite.syntax import nodes
from scenic_lite.values import BehaviorCall, Builtin, Instance, Namespace, ScenicClass, describe_kind

MOST_WALKS = 40
EXPRESSIONS: dict[type, Callable[[Compilation, Frame, Any], Value]] = {
    ast.Call: call_node,
    ast.Attribute: attribute_of,
    ast.BinOp: binary,
    ast.UnaryOp: unary,
    ast.Subscript: subscript,
    ast.FormattedValue: formatted,
    ast.BoolOp: boolean,
    ast.IfExp: conditional,
    ast.Compare: comparison,
    ast.ListComp: comprehension,
    ast.GeneratorExp: comprehension,
    ast.SetComp: comprehension,
    ast.DictComp: dictionary_comprehension,
    nodes.Operator: scenic_operator,
}


def compile_program(program: Program, world: World) -> Compiled:
    """The code of a program in a world. Raises ScenicError, with its place, for what cannot be compiled."""
    if program.main is not None and needs_reference(program.main):
        message = "modular scenarios with a compose block run in the reference interpreter only"
        raise program.error("unsupported", message, program.main.place)
    shapes: dict[tuple, Shape] = {}
    simulation = Namespace("simulation()", {}, open=True)
    modules: dict[int, dict[str, Value]] = {}
    for _ in range(MOST_WALKS):
        compilation = Compilation(program, world, program.session, Assembler(), shapes, simulation, modules)
        with lent(compilation):
            threads = walk(compilation)
        if not compilation.code.widened:
            return finished(compilation, threads)
    raise ScenicError("budget", "the variables of the program's behaviors can be too many things")


def needs_reference(main: BehaviorCall) -> bool:
    """Whether a main scenario does anything while a match runs; one that is only a setup was executed when loaded."""
    node = main.behavior.node
    return bool((isinstance(node, nodes.Scenario) and node.compose) or node.preconditions or node.invariants)


@contextmanager
def lent(c: Compilation) -> Iterator[None]:
    """Inside, the session evaluates for the compiler, and objects have live properties."""
    session = c.session
    outside = dict(vars(session))
    instances = list(c.program.instances)
    loaded = [(each.properties, each.attributes) for each in instances]
    for each in instances:
        each.properties, each.attributes = dict(each.properties), dict(each.attributes)
    vars(session).update(meanings(c))
    try:
        yield
    finally:
        vars(session).clear()
        vars(session).update(outside)
        for each, (properties, attributes) in zip(instances, loaded, strict=True):
            each.properties, each.attributes = properties, attributes
        for number, before in c.before.items():
            c.modules[number].update(before)


def meanings(c: Compilation) -> dict[str, Any]:
    """The fields of the session that differ while a program is compiled."""
    session = c.session
    own: dict[type, Any] = {kind: partial(handler, c) for kind, handler in EXPRESSIONS.items()}
    statements = {kind: guarded(c, handler) for kind, handler in (STATEMENTS | DYNAMIC).items()}
    simulation = Builtin("simulation", lambda: c.simulation, lifted=False)

    def call(frame: Frame, function: Value, arguments: list, keywords: dict[str, Value], node: ast.AST) -> Value:
        return call_value(c, frame, function, arguments, keywords, node)

    return {
        "expressions": session.expressions | own | {nodes.New: new},
        "statements": session.statements | statements,
        "call": call,
        "column": partial(draw, c),
        "in_requirement": 1,
        "owner": None,
        "points": [],
        "requirements": [],
        "handled": [],
        "budget": Budget(session.budget.limits),
        "builtins": session.builtins | {"simulation": simulation},
    }


def draw(c: Compilation, kind: str, place: Place, offset: float = 0.0, span: float = 1.0) -> Column:
    """A number from the match's stream, drawn where the program is now."""
    code = c.code
    register = code.temporaries.take()
    code.row(Op.DRAW, register, code.constant(offset), code.constant(span))
    return DrawnNow(register, kind, place, offset, span)


def new(frame: Frame, node: nodes.New) -> Value:
    """A point that a behavior speaks of; objects are made before the match."""
    cls = frame.value(node.cls)
    if not isinstance(cls, ScenicClass):
        if not node.certain:
            return cls if node.operator is None else frame.value(node.operator)
        raise frame.error("type", f"{describe_kind(cls)} is no class to make an object of", node.cls)
    if cls.derives_from(OBJECT):
        hint = "make it before, or in the setup of a scenario"
        raise ScenicError("type", "no object can be made in a behavior", hint=hint)
    instance = Instance(cls, frame.place(node))
    return make(frame, cls, [meaning(frame, instance, each) for each in node.specifiers], instance)


# ------------------------------------------------------------ one walk


def walk(c: Compilation) -> list[tuple[int, int, Label, str]]:
    """Compile everything once; the threads: slot, object, entry, title."""
    code = c.code
    code.row(Op.END, code.fixed.take())  # row 0: where a thread stands that has ended
    code.reachable = False
    show_world(c)
    threads: list[tuple[int, int, Label, str]] = []
    show_shared(c)
    agents, monitors = calls_of(c)
    movers = [agent for _, agent, _ in agents]
    guards: list[tuple[Instance | None, BehaviorCall]] = [(agent, call) for _, agent, call in agents]
    guards += [(None, call) for call in monitors]
    if any(has_guards(call) for _, call in guards):
        every(c, threads, "guards", lambda: start(c, guards), once=True)
    made: list = []
    if c.program.temporal:
        every(c, threads, "temporal requirements", lambda: made.extend(temporal(c)))
    if c.program.terminations:
        every(c, threads, "terminate when", lambda: ends_of_scenario(c))
    scenarios = len(threads)
    if c.remembering and c.program.dialect == 3:
        every(c, threads, "lastActions", lambda: forget(c, movers))
    for number, agent, call in agents:
        c.agent = agent
        body(c, threads, number, call, f"{agent.title()}: {call.behavior.name}")
    c.agent = None
    if c.remembering and c.program.dialect == 2:
        every(c, threads, "lastActions", lambda: reveal(c, movers))
    c.counts = (scenarios, len(threads) - scenarios, len(monitors))
    for call in monitors:
        body(c, threads, -1, call, f"monitor {call.behavior.name}")
    every(c, threads, "terminate simulation when", lambda: conditions(c, "simulation"))
    every(c, threads, "at the end", lambda: unsatisfied(c, made))
    return threads


def calls_of(c: Compilation) -> tuple[list[tuple[int, Instance, BehaviorCall]], list[BehaviorCall]]:
    """The behaviors of the objects and the monitors."""
    agents = []
    for number, instance in enumerate(c.program.instances):
        call = instance.properties["behavior"]
        if isinstance(call, BehaviorCall):
            agents.append((number, instance, call))
    return agents, list(c.program.monitors)


def has_guards(call: BehaviorCall) -> bool:
    return bool(call.behavior.node.preconditions or call.behavior.node.invariants)


def show_world(c: Compilation) -> None:
    """Give the objects their live properties and `simulation()` its meaning."""
    world, program, code = c.world, c.program, c.code
    c.remembering = any("lastActions" in line for source in program._sources.values() for line in source.lines)
    c.world_base = code.fixed.take(len(program.instances) * len(world.fields))
    c.fact_base = code.fixed.take(len(world.facts))
    facts = {name: Live(c.fact_base + i, whole=name == "time") for i, name in enumerate(world.facts)}
    c.clock = facts.get("time")
    names: set[str] = set()
    for number, instance in enumerate(program.instances):
        first = c.world_base + number * len(world.fields)
        fields: dict[str, Value] = {}
        for i, name in enumerate(world.fields):
            fields[name] = Live(first + i)
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
    c.simulation.names["scenic_reward"] = Live(REWARD)


def update(old: Namespace, new: Namespace) -> None:
    """Let a namespace that variables hold since an earlier walk show this one's registers."""
    inner = {name: value for name, value in old.names.items() if isinstance(value, Namespace)}
    old.names.clear()
    old.names.update(new.names)
    for name, value in inner.items():
        if isinstance(new.names.get(name), Namespace):
            old.names[name] = value
            update(value, new.names[name])


def every(c: Compilation, threads: list, title: str, write: Callable[[], object], once: bool = False) -> None:
    """A thread that runs from its beginning in every step, or once."""
    code = c.code
    slot, entry = code.fixed.take(), Label()
    begin(code, entry)
    with code.statement():
        write()
    if once:
        code.row(Op.END, slot)
    else:
        code.row(Op.WAIT, 0, slot, entry)
    code.reachable = False
    threads.append((slot, -1, entry, title))


def begin(code: Assembler, entry: Label) -> None:
    """A thread starts here; its variables are its own."""
    code.variables.used = code.variables.most
    code.place = None
    code.reachable = True
    entry.used = True
    code.put_loop(entry)


def body(c: Compilation, threads: list, number: int, call: BehaviorCall, title: str) -> None:
    """The thread of a behavior or monitor."""
    code = c.code
    slot, entry = code.fixed.take(), Label()
    begin(code, entry)
    code.place = call.place
    with code.statement(), c.block(slot), c.round(call.behavior.node, number):
        run_behavior(c, call, call.behavior.node, guards=False)
    code.row(Op.END, slot)
    code.reachable = False
    threads.append((slot, number, entry, title))
