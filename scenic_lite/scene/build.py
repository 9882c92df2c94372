"""From what a load has made to a Program: one recipe, whose stages each return what the next ones need.

Read next: `scene.program`, the result; `scene.constraints`, `scene.scenes`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

import numpy as np

from scenic_lite.core.checks import SceneChecks
from scenic_lite.core.per_sample import reached
from scenic_lite.core.state import LoadState, Mode
from scenic_lite.core.types import BehaviorCall, Environment, Instance, Source, randoms_in
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene.constraints import Constraint, Constraints, constraint_of_requirement, constraints_of
from scenic_lite.scene.naming import Draw, ThetaLayout, column_names, name_arguments, name_objects, title_of
from scenic_lite.scene.program import Program
from scenic_lite.scene.scenes import ScenePlan, info_of, refuse_huge
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, columns_of


def build_program(mode: Mode, source: Source, text: str, warnings: tuple[ScenicError, ...]) -> Program:
    """Make the Program of a load whose statements have all run. Raises ScenicError if it can have no scene."""
    state = mode.state
    objects = name_objects(sorted(state.objects, key=lambda instance: instance is not state.ego))  # the ego first
    constraints = constraints_of(state, objects)
    read_in_episodes = values_read_in_episodes(state, objects)
    refuse_huge_values(state, objects)
    roots = list(random_roots(state, objects, constraints, read_in_episodes))
    layout = lay_out_theta(state, objects, [node for node, _ in roots], source.file)
    tape = tape_of(state, roots, layout.columns)
    constraints.read_from(tape)
    checks = state.watching.checks.values()
    runtime_checks = SceneChecks(checks, tape, constraint_of_requirement(state, constraints))
    plan = ScenePlan(tape, objects, state.params)
    program = Program(
        source=text,
        file=source.file,
        dialect=state.dialect,
        warnings=warnings,
        printed=tuple(mode.state.printed),
        objects=tuple(info_of(instance) for instance in objects),
        instances=objects,
        params=plan.params,
        param_places=dict(state.param_places),
        requirements=constraints.all,
        behaviors=state.behaviors,
        monitors=tuple(state.monitors),
        terminations=tuple(state.terminations),
        records=tuple(state.records),
        temporal=tuple(state.temporal),
        main=state.main,
        main_frame=state.main_frame,
        read_in_episodes=read_in_episodes,
        mode=mode,
        layout=layout,
        tape=tape,
        constraints=constraints,
        runtime_checks=runtime_checks,
        plan=plan,
    )
    refuse_impossible(program)
    return program


# ------------------------------------------------------------ what is random


def values_read_in_episodes(state: LoadState, objects: list[Instance]) -> list[Value]:
    """Return every value that the dynamic half of a program names, directly or through functions and behaviors.

    What is random in them is sampled with the scene; what a behavior draws itself is not.
    """
    attached = [instance.properties["behavior"] for instance in objects]
    calls = [value for value in (*attached, *state.monitors) if isinstance(value, BehaviorCall)]
    watched = (*state.terminations, *state.records, *state.temporal)
    pending: list[tuple[Environment, ast.AST]] = [(statement.scope, statement.tree) for statement in watched]
    for call in calls:
        pending += [(call.behavior.scope, part) for part in call.behavior.trees()]
    if state.main is not None and state.main_frame is not None:
        pending.append((state.main_frame, state.main.behavior.node))
    durations = [item.duration for item in state.terminations]
    return [*(call.arguments for call in calls), *durations, *reached(pending)]


def refuse_huge_values(state: LoadState, objects: list[Instance]) -> None:
    """Raise ScenicError for a property or parameter that scenes cannot hold."""
    for instance in objects:
        with state.placing(instance.place):
            refuse_huge(instance.properties, f"a property of {instance.title()}")
    for name, value in state.params.items():
        with state.placing(state.param_places[name]):
            refuse_huge(value, f"the parameter '{name}'")


def random_roots(
    state: LoadState, objects: list[Instance], constraints: Constraints, read_in_episodes: list[Value]
) -> Iterator[tuple[RandomExpr, SourceSpan | None]]:
    """Yield the random nodes that scenes and episodes are made of, each with the statement that makes it needed."""
    for instance in objects:
        yield from ((node, instance.place) for node in randoms_in(instance))
    for name, value in state.params.items():
        yield from ((node, state.param_places[name]) for node in randoms_in(value))
    yield from ((value, constraint.place) for constraint, value in constraints.nodes if isinstance(value, RandomExpr))
    for value in read_in_episodes:
        yield from ((node, None) for node in randoms_in(value))


def tape_of(state: LoadState, roots: list[tuple[RandomExpr, SourceSpan | None]], columns: list[ThetaColumn]) -> Tape:
    """Return the tape of all roots. Raises ScenicError, at the first statement that needs too much of it."""
    reached: list[SourceSpan | None] = []

    def nodes() -> Iterator[RandomExpr]:
        for node, place in roots:
            reached.append(place)
            yield node

    try:
        return Tape(nodes(), columns, state.budget.limits.operations)
    except ScenicError as error:
        with state.placing(reached[-1]):
            raise error from None


def lay_out_theta(state: LoadState, objects: list[Instance], roots: list[RandomExpr], file: str) -> ThetaLayout:
    """Return the columns of θ: the draws that reach any root, in order of first appearance, named."""
    used = {id(column) for column in columns_of(*roots)}
    columns = [column for column in state.columns if id(column) in used]
    name_arguments(objects)
    draws = tuple(
        Draw(name, column.draw_kind, column.low, column.high, place_in_program(column, state))
        for name, column in zip(column_names(columns), columns, strict=True)
    )
    return ThetaLayout(file, columns, draws)


def place_in_program(column: ThetaColumn, state: LoadState) -> SourceSpan:
    """Return where a value is drawn; for a default of a library's class, where its object is made."""
    place, owner = column.place, column.owner
    while state.sources[place.file].library and owner is not None:
        place, owner = owner[0].place, owner[0].owner
    return place


# ------------------------------------------------------------ three trial rows


def refuse_impossible(program: Program) -> None:
    """Raise ScenicError for constraints that fixed objects violate, and for operations on mixed kinds."""
    trial = np.linspace(-0.9, 0.9, 3)[:, None] * np.ones(program.dim)  # [3, D]
    try:
        scenes = program.instantiate(trial)
    except ScenicError:
        raise
    except (TypeError, ValueError, ArithmeticError, LookupError) as fault:
        message = f"the random values of the program do not fit together: {fault}"
        raise program.error("type", message, SourceSpan(program.file, 1, 0, 1, 1)) from None
    fixed = [not any(True for _ in randoms_in(outline_parts(instance))) for instance in program.instances]
    for number, (constraint, members) in enumerate(program.constraints.members()):
        if all(fixed[i] for i in members) and scenes.failed[0, number]:
            raise violated_always(program, constraint, [program.instances[i] for i in members])
    for constraint, value in program.constraints.nodes:
        if value is False and constraint.kind != "require":
            raise violated_always(program, constraint, [])


def outline_parts(instance: Instance) -> list[Value]:
    return [instance.properties[name] for name in ("position", "heading", "width", "length", "allowCollisions")]


def violated_always(program: Program, constraint: Constraint, members: list[Instance]) -> ScenicError:
    where = ", ".join(f"{title_of(instance)} is at {instance.properties['position']!r}" for instance in members)
    return program.error("value", f"{constraint.label} in every scene", constraint.place, where)
