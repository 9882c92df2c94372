"""Compile the behaviors, monitors, endings and scenarios of a program into code for the machine.

The one idea: **the compiler is the static evaluator, run with registers as leaves of its expression graph.** What
makes scenes also evaluates `distance from self to ball` here; only that `self.x` is a register of the running match,
so that the graph becomes rows of the machine and no column of a scene. Arithmetic, specifiers, operators and geometry
are therefore written once. Code of their own need only

    statements, by jumps                                `statements`, `behaviors`, `interrupts`
    values that are one of several, conditions          `choices`, `expressions`
    lists whose length the match decides                `lists`
    variables, by the type that they are assigned       `types`, `registers`
    operations of the graph, one row each               `emit`
    scenarios that run inside each other                `scenarios`, `watchers`
    threads, and the arrays of a finished program       `threads`, `layout`

Behaviors and functions are written in place where they are called. A loop `best = None; for o in ...: best = o` reads
a variable before the text says what else it holds: a walk over the program that finds a type too late is followed by
another that knows it. Read next: `dynamics.compiler.statements`, the plainest part; `dynamics.machine.compiled`, which
plays a match.
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
from scenic_lite.core.types import Builtin, Environment, Instance, Namespace, ScenicClass, describe_kind
from scenic_lite.core.world import World
from scenic_lite.dynamics.compiler.behaviors import DYNAMIC
from scenic_lite.dynamics.compiler.code import Assembler, DrawnNow
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope
from scenic_lite.dynamics.compiler.expressions import EXPRESSIONS, call_value, dictionary, for_undecided
from scenic_lite.dynamics.compiler.layout import finished
from scenic_lite.dynamics.compiler.registers import TypeTable
from scenic_lite.dynamics.compiler.scenarios import SETTING_UP
from scenic_lite.dynamics.compiler.statements import STATEMENTS
from scenic_lite.dynamics.compiler.threads import walk
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.compiled import Compiled
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.evaluation.calls import meaning
from scenic_lite.language.classes import OBJECT
from scenic_lite.language.specifiers import make
from scenic_lite.scene.program import Program
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import ThetaColumn, Value

MOST_WALKS = 12


def compile_program(program: Program, world: World) -> Compiled:
    """Return the code of a program in a world. Raises ScenicError, with its place, for what cannot be compiled."""
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
    """Return what a name stands for; a match that has given it no value yet stops."""
    at: Environment | None = scope
    while at is not None and node.id not in at.locals and not (isinstance(at, CompiledScope) and node.id in at.unset):
        at = at.outer
    if isinstance(at, CompiledScope):
        at.check_set(node.id)
    return dictionary(handler, scope, node)


def draw(c: Compilation, kind: str, place: SourceSpan, offset: float, span: float) -> ThetaColumn:
    """Return a number from the match's stream, drawn where the program is now."""
    code = c.code
    register = code.temporaries.take()
    code.row(op.DRAW, register, code.constant(offset), code.constant(span))
    return DrawnNow(register, kind, place, offset, span)


def new(c: Compilation, scope: Scope, node: nodes.New) -> Value:
    """Return a point that a behavior speaks of; objects are made before the match."""
    cls = scope.value(node.cls)
    if not isinstance(cls, ScenicClass):
        if not node.certain:
            return cls if node.operator is None else scope.value(node.operator)
        raise scope.error("type", f"{describe_kind(cls)} is no class to make an object of", node.cls)
    if cls.derives_from(OBJECT):
        if c.site.setting_up:
            message = "objects that a scenario makes while a match runs are played by the reference only"
            raise ScenicError("unsupported", message, hint="make them in the main scenario")
        hint = "make it before, or in the setup of a scenario"
        raise ScenicError("type", "no object can be made in a behavior", hint=hint)
    instance = Instance(cls, scope.place(node))
    return make(scope, cls, [meaning(scope, instance, each) for each in node.specifiers], instance)


def with_location(
    compilation: Compilation, handler: Callable[[Compilation, CompiledScope, Any], None]
) -> Callable[[CompiledScope, Any], None]:
    """Return a handler of statements that notes the place of the rows it writes.

    A statement that cannot be executed as it is found to be (a name that is not there, a region that moves) stops a
    match that comes to it, as in the reference; what cannot be compiled refuses the program.
    """

    def handle(scope: CompiledScope, node: ast.stmt) -> None:
        code = compilation.code
        before, code.place = code.place, scope.place(node)
        start, known = len(code.rows), len(compilation.output.doubts)
        try:
            with code.statement():
                handler(compilation, scope, node)
        except FAULTS as fault:
            error = scope.placed(as_error(fault), node)
            if error.kind in REFUSALS:
                raise
            inner = [each for each in compilation.output.doubts[known:] if each.kind != "warning"]
            if inner and not code.reachable:  # a function has failed before, and so this is not come to
                error = inner[0]
            else:
                compilation.output.doubts.append(error)
            del code.rows[start:]
            code.reachable = True
            compilation.stop_with(error)
        finally:
            code.place = before

    return handle


REFUSALS = frozenset({"unsupported", "budget", "syntax", "import"})
