"""Program, the main interface of the package: it maps θ to scenes and samples valid θ.

    program = load("free.scenic")                         evaluate the text once
    theta, scenes = program.sample(256, rng)              [256, D] valid θ, and their scenes
    scenes = program.instantiate(theta)                   the same scenes: θ determines a scene
    scenes.positions, scenes.ok                           [256, O, 2], [256]

`Range(0, 80)` is a node that reads a column of θ; `Range(0, 80) + 2` is a node that reads the first node. The walk
creates the graph of all values in scenes, and a Program compiles the graph into a flat tape. One array operation per
node then turns N rows of θ into N scenes. The language is Scenic (Fremont et al. 2019); θ holds the free parameters of
a UPOMDP (Dennis et al. 2020). Constraints are also nodes, or tests of all objects at once. A row that violates a
constraint is rejected, and `sample` draws another row.
Read next: `values.graph` for the tape, `scene.scenes`, `scene.constraints`.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from scenic_lite.core.checks import CheckResults, checks_on
from scenic_lite.core.per_sample import PerSampleCondition, reached
from scenic_lite.core.state import LoadState, Mode
from scenic_lite.core.types import BehaviorCall, Environment, Instance, Source, randoms_in
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene import constraints, naming
from scenic_lite.scene.constraints import Outlines
from scenic_lite.scene.scenes import ScenePlan, Scenes, info_of, refuse_huge
from scenic_lite.scene.theta import theta_of
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, columns_of
from scenic_lite.values.regions import Region

FIRST_DRAWS = 4096  # if none of these draws is valid, sampling fails
DRAWS_PER_SCENE = 20_000  # maximum number of further draws, so that sampling always ends
OUTLINE = ("position", "heading", "width", "length", "allowCollisions")  # properties that determine overlaps


class Program:
    """A compiled `.scenic` source, created by `load`.

    Attributes:
        source, file: the text and its origin; `dialect` 2 or 3.
        warnings: valid code that is probably a mistake.
        printed: lines that the program printed while it was loaded.
        objects: the O objects, first the ego, then in order of creation; `instances`: the interpreter's objects.
        params: the parameters with fixed values; `Scenes.params` holds random ones.
        param_places: the place that sets each parameter; `fixed_params`: the parameters that the caller of `load` set.
        requirements: the R constraints of a scene, in the order of `Scenes.failed`.
        behaviors, monitors, terminations, records, temporal: the dynamic part of the program, as trees.
        main: the main modular scenario, if the program has one; `main_frame` holds its names.
        read_in_episodes: the values that behaviors, monitors and conditions read.
        mode: the mode in which `scenic_lite.dynamics` evaluates the trees.
        layout: the D columns of θ, in order of first appearance.

    A loaded Program is immutable, so a copy is the program itself. It is not thread-safe and cannot be pickled.
    Another process loads the same text, which maps the same θ to the same scenes.
    """

    def __init__(self, mode: Mode, source: Source, text: str, warnings: tuple[ScenicError, ...]) -> None:
        """Create the Program of a load after its last statement. Raises ScenicError if it has no valid scene."""
        state = mode.state
        self.mode, self.source, self.file, self.dialect = mode, text, source.file, state.dialect
        self.warnings, self.printed = warnings, tuple(state.printed)
        self.behaviors, self.param_places = state.behaviors, dict(state.param_places)
        self.fixed_params = state.fixed_params
        self.main, self.main_frame = state.main, state.main_frame
        self.monitors, self.terminations = tuple(state.monitors), tuple(state.terminations)
        self.records, self.temporal = tuple(state.records), tuple(state.temporal)
        objects = sorted(state.objects, key=lambda instance: instance is not state.ego)  # the ego first
        self.instances = naming.name_objects(objects)
        self.objects = tuple(info_of(instance) for instance in objects)
        self._constraints = constraints.constraints_of(state, objects)
        self.requirements = self._constraints.all
        self.read_in_episodes = values_read_in_episodes(state, objects)
        refuse_huge_values(state, objects)
        conditions = [value for _, value in self._constraints.nodes]
        values = [*objects, *state.params.values(), *conditions, *self.read_in_episodes]
        roots = [node for value in values for node in randoms_in(value)]
        self.layout = lay_out_theta(state, objects, roots, self.file)
        with state.with_location(source.start):
            self.tape = Tape(roots, self.layout.columns, state.budget.limits.operations)
        self._constraints.read_from(self.tape)
        rules = constraints.constraint_of_requirement(state, self._constraints)
        self._checks = checks_on(self.tape, state.watching.checks.values(), rules)
        self._plan = ScenePlan(self.tape, objects, state.params)
        self.params = self._plan.params
        self._refuse_impossible()

    def __copy__(self) -> Program:
        return self

    def __deepcopy__(self, _memo: dict[int, Any]) -> Program:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError(f"a Program cannot be pickled: pass the text of {self.file} to the other process")

    @property
    def dim(self) -> int:
        """Return D, the number of columns of θ."""
        return len(self.layout.draws)

    @property
    def draws(self) -> tuple[naming.Draw, ...]:
        """Return the descriptions of the D columns of θ."""
        return self.layout.draws

    @property
    def workspace(self) -> Region | None:
        """Return the region that must contain all objects without their own container, or None."""
        return self.mode.state.workspace

    @property
    def drawn_regions(self) -> tuple[Region, ...]:
        """Return the regions from which the program draws points, before pruning."""
        return tuple(dict.fromkeys(drawn.whole or drawn.region for drawn in self.mode.state.points))

    def error(self, kind: str, message: str, place: SourceSpan, hint: str = "") -> ScenicError:
        """Return an error at a place of the program, for callers that reject the program."""
        return ScenicError(kind, message, place, hint=hint, source_line=self.line_of(place))

    def line_of(self, place: SourceSpan) -> str:
        """Return the source line, of the program or a module, in which a place begins."""
        source = self.mode.state.sources.get(place.file)
        return "" if source is None else source.line(place.line)

    # ------------------------------------------------------------ from θ to scenes

    def instantiate(self, theta: np.ndarray) -> Scenes:
        """Return the N scenes of theta [N, D], clipped to [-1, 1]; rows are independent.

        A row without a valid scene does not raise an error: its `ok` is False.
        """
        self.mode.budget.new_call()
        registers, outlines, ok, failed, _ = self._evaluate(self.layout.checked(theta))
        positions, headings = self._plan.arrangement.placed(outlines, len(ok))
        properties, params, arguments = self._plan.read(registers, len(ok))
        return Scenes(positions, headings, properties, params, arguments, ok, failed.T)

    def valid(self, theta: np.ndarray) -> np.ndarray:
        """Return whether each row of theta [N, D] describes a valid scene: [N] bool."""
        self.mode.budget.new_call()
        return self._evaluate(self.layout.checked(theta))[2]

    def row(self, theta: np.ndarray) -> dict[RandomExpr, float]:
        """Return the draws of one row theta [D], for `Mode.row`."""
        return self.layout.row(theta)

    def describe(self, theta: np.ndarray) -> dict[str, Any]:
        """Return the draws of one row theta [D] by name, in the program's units."""
        with np.errstate(all="ignore"):
            registers = self._shown.run(self.layout.scaled(self.layout.checked(np.asarray(theta, dtype=float)[None])))
        values = {}
        for draw, column in zip(self.draws, self.layout.columns, strict=True):
            value = registers[self._shown.slot(column.shown)][0]
            value = value.item() if hasattr(value, "item") else value
            values[draw.name] = naming.titles_of_options(column.options)[value] if column.options else value
        return values

    @cached_property
    def _shown(self) -> Tape:
        """Return the tape of the readable values of all columns."""
        return Tape([column.shown for column in self.layout.columns], self.layout.columns, 10**9)

    def _evaluate(self, theta: np.ndarray) -> tuple[list[Any], Outlines, np.ndarray, np.ndarray, CheckResults]:
        """Return the registers of theta [N, D], `outlines`, `ok` [N] and `failed` [R, N], and their faults.

        Sampling needs no more for a candidate; the creation of scenes would double the time.
        """
        count = len(theta)
        scaled = self.layout.scaled(theta)  # [D, N]
        known = np.isfinite(scaled.sum(axis=0))  # [N]
        if not known.all():
            scaled[:, ~known] = self.layout.offset
        with np.errstate(all="ignore"):
            registers = self.tape.run(scaled)
            outlines = self._plan.arrangement.outlines(registers, count)
            failed = self._constraints.failed(registers, outlines, count)  # [R, N]
            faults = CheckResults(self._checks, self.tape, registers, failed)
            violated = failed[self._constraints.hard].any(axis=0)
            placed = outlines.x.sum(axis=0) + outlines.y.sum(axis=0) + outlines.heading.sum(axis=0)
            ok = np.isfinite(placed) & ~violated & ~faults.in_values & known  # [N]
        return registers, outlines, ok, failed, faults

    # ------------------------------------------------------------ sampling

    def _evaluate_candidates(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, CheckResults]:
        """Return `ok` [N] and `failed` [R, N] of theta [N, D], and their faults.

        Conditions that arrays cannot evaluate are slow. As in Scenic, they are evaluated only in rows in which every
        earlier rule holds. In all other rows, which are rejected anyway, they count as false.
        """
        slow = [
            (operation, rule)
            for _, operation, rule in self._checks
            if rule is not None and isinstance(operation, PerSampleCondition)
        ]
        if not slow:
            return self._evaluate(theta)[2:]
        nowhere = np.zeros(len(theta), dtype=bool)
        with ExitStack() as skipped:
            for operation, _ in slow:
                skipped.enter_context(operation.only(nowhere))
            failed = self._evaluate(theta)[3]
        fast = np.array([rule.probability == 1 for rule in self.requirements])
        fast[[rule for _, rule in slow]] = False
        with ExitStack() as evaluated:
            for operation, rule in slow:
                evaluated.enter_context(operation.only(~failed[:rule][fast[:rule]].any(axis=0)))
            return self._evaluate(theta)[2:]

    def sample(self, n: int, rng: np.random.Generator) -> tuple[np.ndarray, Scenes]:
        """Draw n valid scenes uniformly by rejection; return theta [n, D] and its Scenes. See `sample_theta`."""
        theta = self.sample_theta(n, rng)
        return theta, self.instantiate(theta)

    def sample_theta(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """Draw theta [n, D] of n valid scenes, uniformly by rejection.

        Each scene draws once whether a soft requirement is active in it, with the requirement's probability.

        Raises:
            ScenicError: of kind `rejection`, with the report, if too few draws are valid; of another kind if the
                evaluation of a requirement fails in a scene.
        """
        if n < 0:
            raise ValueError(f"a number of scenes is 0 or more, not {n}")
        soft = [i for i, constraint in enumerate(self.requirements) if constraint.probability < 1]
        in_force = np.ones((n, len(self.requirements)), dtype=bool)  # [n, R]
        for i in soft:
            in_force[:, i] = rng.random(n) < self.requirements[i].probability
        theta = np.empty((n, self.dim))
        pending = np.arange(n)  # [P], scenes that still have no valid draw
        draws = accepted = 0
        self.mode.budget.new_call(n)
        while len(pending):
            if draws >= (FIRST_DRAWS if len(pending) == n else FIRST_DRAWS + DRAWS_PER_SCENE * n):
                raise self._impossible(rng, n - len(pending), n, draws)
            tries = tries_for_each(len(pending), draws, accepted)  # K
            candidates = rng.uniform(-1.0, 1.0, (len(pending) * tries, self.dim))  # [P * K, D]
            valid, violated, faults = self._evaluate_candidates(candidates)
            violated = violated.T  # [P * K, R]
            if soft:
                violated = violated & np.repeat(in_force[pending], tries, axis=0)
                valid = valid & ~violated.any(axis=1)
            valid = valid.reshape(len(pending), tries)  # [P, K]
            if faults.any:
                tried = valid.cumsum(axis=1) <= valid  # candidates count in order, up to the first valid one
                faults.raise_first(violated, tried.ravel())
            draws, accepted = draws + len(candidates), accepted + int(valid.sum())
            solved = valid.any(axis=1)  # [P]
            first_valid = np.arange(len(pending)) * tries + valid.argmax(axis=1)  # [P], row indices of the candidates
            theta[pending[solved]] = candidates[first_valid[solved]]
            pending = pending[~solved]
        return theta

    def report(self, n: int, rng: np.random.Generator) -> constraints.RejectionReport:
        """Return a report with the share of n uniform draws that each constraint rejects."""
        if n < 1:
            raise ValueError(f"a report needs at least one draw, not {n}")
        scenes = self.instantiate(rng.uniform(-1.0, 1.0, (n, self.dim)))
        shares = scenes.failed.mean(axis=0)  # [R]
        order = sorted(range(len(shares)), key=lambda i: -shares[i])
        rejected = tuple((self.requirements[i], float(shares[i])) for i in order if shares[i] > 0)
        return constraints.RejectionReport(self.file, n, int(scenes.ok.sum()), rejected)

    def _impossible(self, rng: np.random.Generator, solved: int, n: int, draws: int) -> ScenicError:
        report = replace(self.report(FIRST_DRAWS, rng), accepted=0)
        if not solved:
            return ScenicError("rejection", str(report))
        head = f"{self.file}: only {solved} of {n} scenes found in {draws:,} draws"
        return ScenicError("rejection", "\n".join([head, *report.lines()]))

    # ------------------------------------------------------------ from scenes to θ

    def theta(self, description: Mapping[Any, Any], default: np.ndarray | None = None) -> np.ndarray:
        """Return the rows of theta [N, D] of described scenes, valid or not: the inverse of `instantiate`.

        An example of `description` is `{"ego": (30, 5), "keeper": (98, 0, 1.57)}`. A key is an object (label or index),
        a parameter or a draw. The value of an object is (x, y), (x, y, heading in radians) or a dict of properties. A
        number or text may be an array [N], a position an array [N, 2]. `default` [D] or [N, D] sets all other draws.

        Raises:
            ScenicError: some draws are undetermined, or no θ was found for a value; the message names them.
        """
        if not isinstance(description, Mapping):
            raise TypeError(f"scenes are described like {{'ego': (30, 5)}}, not by {description!r:.80}")
        if default is not None:
            default = np.clip(self.layout.checked(np.atleast_2d(default)), -1.0, 1.0)
        try:
            return theta_of(self.mode.state, self.instances, self.layout, description, default)
        except ScenicError as error:
            if error.place is not None:
                error.source_line = self.line_of(error.place)
            raise

    # ------------------------------------------------------------ three trial rows

    def _refuse_impossible(self) -> None:
        """Raise ScenicError for constraints that fixed objects violate, and for operations on values of mixed kinds."""
        trial = np.linspace(-0.9, 0.9, 3)[:, None] * np.ones(self.dim)  # [3, D]
        try:
            scenes = self.instantiate(trial)
        except ScenicError:
            raise
        except (TypeError, ValueError, ArithmeticError, LookupError) as fault:
            message = f"the random values of the program do not fit together: {fault}"
            raise self.error("type", message, SourceSpan(self.file, 1, 0, 1, 1)) from None
        parts = [[instance.properties[name] for name in OUTLINE] for instance in self.instances]
        fixed = [next(randoms_in(values), None) is None for values in parts]
        for number, (constraint, members) in enumerate(self._constraints.members()):
            if all(fixed[i] for i in members) and scenes.failed[0, number]:
                raise self._violated_always(constraint, [self.instances[i] for i in members])
        for constraint, value in self._constraints.nodes:
            if value is False and constraint.kind != "require":
                raise self._violated_always(constraint, [])

    def _violated_always(self, constraint: constraints.Constraint, members: list[Instance]) -> ScenicError:
        where = ", ".join(
            f"{naming.title_of(instance)} is at {instance.properties['position']!r}" for instance in members
        )
        return self.error("value", f"{constraint.label} in every scene", constraint.place, where)


def tries_for_each(pending: int, draws: int, accepted: int) -> int:
    """Return the number of candidates for each pending scene, so that most scenes get a valid candidate."""
    likely = (draws + 1) // (accepted + 1) + 1 if draws else 1
    return max(1, min(likely, FIRST_DRAWS // pending))


# ------------------------------------------------------------ random values
def values_read_in_episodes(state: LoadState, objects: list[Instance]) -> list[Value]:
    """Return all values that behaviors and monitors read, directly or through functions and other behaviors.

    The random values among them are sampled with the scene. Draws inside a behavior are sampled in the episode.
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
    """Raise ScenicError for a property or parameter that is too large for a scene."""
    for instance in objects:
        with state.with_location(instance.place):
            refuse_huge(instance.properties, f"a property of {instance.title()}")
    for name, value in state.params.items():
        with state.with_location(state.param_places[name]):
            refuse_huge(value, f"the parameter '{name}'")


def lay_out_theta(state: LoadState, objects: list[Instance], roots: list[RandomExpr], file: str) -> naming.ThetaLayout:
    """Return the named columns of θ: the draws on which any root depends, in order of first appearance."""
    used = {id(column) for column in columns_of(*roots)}
    columns = [column for column in state.columns if id(column) in used]
    naming.name_arguments(objects)
    draws = tuple(
        naming.Draw(name, column.draw_kind, column.low, column.high, place_in_program(column, state))._replace(
            options=naming.titles_of_options(column.listed), weights=column.weights
        )
        for name, column in zip(naming.column_names(columns), columns, strict=True)
    )
    return naming.ThetaLayout(file, columns, draws)


def place_in_program(column: ThetaColumn, state: LoadState) -> SourceSpan:
    """Return the place of a draw; for a default of a library class, the place that creates the object."""
    place, owner = column.place, column.owner
    while state.sources[place.file].library and owner is not None:
        place, owner = owner[0].place, owner[0].owner
    return place
