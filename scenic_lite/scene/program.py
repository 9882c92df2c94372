"""Program: the layout of θ, and scenes, validity and samples from it; the seam of this package.

`load` makes one. The text was walked once; here only a flat tape of array operations is left. Read next:
`scene.scenes`, `scene.constraints`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from scenic_lite.core.checks import Faults, Found
from scenic_lite.core.environment import Source
from scenic_lite.core.state import LoadState, Mode
from scenic_lite.core.types import BehaviorCall, Instance, randoms_in
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene.constraints import Constraint, checks_of, rules_of_requirements
from scenic_lite.scene.free_variables import read_in_episodes
from scenic_lite.scene.naming import Draw, column_names, name_arguments, name_objects, title_of, title_of_option
from scenic_lite.scene.outlines import Area, areas_of
from scenic_lite.scene.rejection import RejectionReport
from scenic_lite.scene.scenes import Arrangement, ObjectInfo, Planner, Scenes, refuse_huge
from scenic_lite.scene.theta import Subject, theta_of
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, columns_of

FIRST_DRAWS = 4096  # if none of so many is valid, the program counts as impossible
DRAWS_PER_SCENE = 20_000  # thereafter, so that sampling always ends


class Program:
    """A compiled `.scenic` source. Made by `load`.

    Attributes:
        draws: one Draw for each of the D columns of θ, in order of first appearance.
        objects: the O objects, the ego first, then in order of creation.
        params: the parameters that are the same in every scene; random ones are in `Scenes.params`.
        requirements: the R rules of a scene, in the order of `Scenes.failed`.
        param_places: where each parameter, random or not, was set.
        behaviors, monitors, terminations, records, temporal: the dynamic half, kept as trees.
        main: the modular scenario that the program is, if it is one; its names are those of `main_frame`.
        state: what the trees are evaluated in, by `scenic_lite.dynamics`.
        warnings: what looks like a slip but is legal.
        source, file: the text and where it came from.

    It does not change once it is loaded: copies are the program itself. It is for one thread at a time, and is not
    pickled: another process loads the same text, and maps the same θ to the same scenes.
    """

    def __init__(self, mode: Mode, source: Source, text: str, warnings: tuple[ScenicError, ...]) -> None:
        self.source, self.file = text, source.file
        state = mode.state
        self.dialect = state.dialect
        self.behaviors = state.behaviors
        self.monitors = tuple(state.monitors)
        self.terminations = tuple(state.terminations)
        self.records, self.temporal = tuple(state.records), tuple(state.temporal)
        self.main, self.main_frame = state.main, state.main_frame
        self.mode = mode
        self.param_places = dict(state.param_places)
        self._sources = state.sources
        self._workspace, self._points = state.workspace, state.points
        self._param_values = state.params
        self.warnings = warnings
        self._instances = in_order(state)
        name_objects(self._instances)
        self._checks = checks_of(state, self._instances)
        self.requirements: tuple[Constraint, ...] = self._checks.rules
        self.objects = tuple(info_of(instance) for instance in self._instances)
        self._lay_out(state)
        self._plan(state)
        self._refuse_impossible()

    def _lay_out(self, state: LoadState) -> None:
        """Find the columns that reach anything, and flatten the graph."""
        roots = list(self._roots(state.params))
        used = {id(column) for column in columns_of(*roots)}
        self._columns = [column for column in state.columns if id(column) in used]
        name_arguments(self._instances)
        names = column_names(self._columns)
        self.draws = tuple(
            Draw(name, column.draw_kind, column.low, column.high, place_in_program(column, state))
            for name, column in zip(names, self._columns, strict=True)
        )
        self._offset = np.array([column.offset for column in self._columns])[:, None]
        self._span = np.array([column.span for column in self._columns])[:, None]
        self._tape = Tape(roots, self._columns, state.budget.limits.operations)
        watches = state.watching.watches.values()
        self._faults = Faults(watches, self._tape, rules_of_requirements(state, self._checks))

    def _roots(self, params: dict[str, Value]) -> Iterable[RandomExpr]:
        for instance in self._instances:
            refuse_huge(instance.properties, f"a property of {instance.title()} in {self.file}")
            yield from randoms_in(instance)
        refuse_huge(params, f"a parameter of {self.file}")
        yield from randoms_in(params)
        yield from (value for _, value in self._checks.nodes if isinstance(value, RandomExpr))
        for value in self.read_in_episodes:
            yield from randoms_in(value)

    def _plan(self, state: LoadState) -> None:
        """Separate what is fixed from what must be read from the tape."""
        planner = Planner(self._tape, self._instances)
        self._arrangement = Arrangement(planner, self._instances)
        plans = {name: planner.plan(value) for name, value in state.params.items()}
        self._param_plans = {name: plan for name, plan in plans.items() if plan is not None}
        self.params = {name: planner.fixed(state.params[name]) for name, plan in plans.items() if plan is None}
        self._properties: dict[str, list[Any]] = {}
        self._property_plans: list[tuple[str, int, Any]] = []
        self._arguments: list[dict[str, Any] | None] = [None] * len(self._instances)
        self._argument_plans: list[tuple[int, Any]] = []
        for i, instance in enumerate(self._instances):
            self._plan_instance(planner, i, instance)
        hard = [i for i, rule in enumerate(self.requirements) if rule.probability == 1]
        self._hard = None if len(hard) == len(self.requirements) else np.array(hard, dtype=int)
        self._slots = [
            self._tape.slot(value) if isinstance(value, RandomExpr) else bool(value) for _, value in self._checks.nodes
        ]

    def _plan_instance(self, planner: Planner, i: int, instance: Instance) -> None:
        for name, value in instance.properties.items():
            if name in ("position", "heading"):
                continue
            column = self._properties.setdefault(name, [None] * len(self._instances))
            plan = planner.plan(value)
            if plan is None:
                column[i] = planner.fixed(value)
            else:
                self._property_plans.append((name, i, plan))
        behavior = instance.properties["behavior"]
        if isinstance(behavior, BehaviorCall):
            self._arguments[i] = planner.fixed(behavior.arguments)
            plan = planner.plan(behavior.arguments)
            if plan is not None:
                self._argument_plans.append((i, plan))

    def __copy__(self) -> Program:
        return self

    def __deepcopy__(self, _memo: dict[int, Any]) -> Program:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError(f"a Program is not pickled: give the other process the text of {self.file}, and load it there")

    # ------------------------------------------------------------ from θ to scenes

    @property
    def dim(self) -> int:
        """D, the number of columns of θ."""
        return len(self.draws)

    def instantiate(self, theta: np.ndarray) -> Scenes:
        """The scenes for theta [N, D] in [-1, 1] (clipped to it), row by row independent of each other.

        Never raises for rows that describe no valid scene: their `ok` is False.
        """
        self.mode.budget.new_call()
        return self._scenes(self._checked(theta))[0]

    def _scenes(self, theta: np.ndarray) -> tuple[Scenes, Found]:
        """The scenes of some rows, and what could not be computed in them."""
        count = len(theta)
        scaled = self._scaled(theta)
        known = np.isfinite(scaled.sum(axis=0))
        if not known.all():
            scaled[:, ~known] = self._offset
        with np.errstate(all="ignore"):
            registers = self._tape.run(scaled)
            positions, headings, outlines = self._arrangement.write(registers, count)
            failed = self._failures(registers, outlines, count)
            found = self._faults.found(registers, failed)
            broken = (failed if self._hard is None else failed[self._hard]).any(axis=0)
            placed = outlines.x.sum(axis=0) + outlines.y.sum(axis=0) + outlines.heading.sum(axis=0)
            ok = np.isfinite(placed) & ~broken & ~found.in_values & known
        properties = self._properties
        if self._property_plans:
            properties = {name: list(column) for name, column in properties.items()}
            for name, i, plan in self._property_plans:
                properties[name][i] = plan(registers, count)
        arguments = list(self._arguments)
        for i, plan in self._argument_plans:
            arguments[i] = plan(registers, count)
        params = self.params | {name: plan(registers, count) for name, plan in self._param_plans.items()}
        return Scenes(positions, headings, properties, params, arguments, ok, failed.T), found

    @cached_property
    def read_in_episodes(self) -> list[Value]:
        """What behaviors, monitors and conditions name."""
        return read_in_episodes(self.mode.state, self._instances)

    @property
    def instances(self) -> list[Instance]:
        """The objects as the evaluator knows them, in the order of `objects`."""
        return self._instances

    def row(self, theta: np.ndarray) -> dict[RandomExpr, float]:
        """The values that one row theta [D] gives to the draws, for `LoadState.row`."""
        scaled = self._scaled(self._checked(np.asarray(theta, dtype=float)[None]))
        return {column: float(value) for column, value in zip(self._columns, scaled[:, 0], strict=True)}

    def valid(self, theta: np.ndarray) -> np.ndarray:
        """Whether each row of theta [N, D] describes a valid scene: [N] bool."""
        return self.instantiate(theta).ok

    def _checked(self, theta: Any) -> np.ndarray:
        wanted = f"theta must be an array of numbers of the shape [N, {self.dim}] for {self.file}"
        try:
            array = np.asarray(theta)
            if array.dtype.kind not in "biuf":
                raise TypeError(f"an array of {array.dtype}")
        except (TypeError, ValueError) as fault:
            raise ValueError(f"{wanted}: {fault}") from None
        if array.ndim != 2 or array.shape[1] != self.dim:
            raise ValueError(f"{wanted}, not {list(array.shape)}")
        return array.astype(float, copy=False)

    def _scaled(self, theta: np.ndarray) -> np.ndarray:
        """Columns [D, N], each contiguous: from [-1, 1] to offset + [0, 1] · span."""
        unit = np.minimum(np.maximum(theta.T, -1.0), 1.0, order="C")
        unit += 1.0
        unit *= 0.5 * self._span
        unit += self._offset
        return unit

    def _failures(self, registers: list[Any], outlines: Any, count: int) -> np.ndarray:
        """[R, N]: which rules do not hold."""
        failed = np.empty((len(self.requirements), count), dtype=bool)
        at = 0
        for check in self._checks.batched:
            failed[at : at + len(check.rules)] = check.fails(outlines)
            at += len(check.rules)
        for slot in self._slots:
            failed[at] = (not slot) if isinstance(slot, bool) else np.logical_not(registers[slot])
            at += 1
        return failed

    # ------------------------------------------------------------ sampling

    def sample(self, n: int, rng: np.random.Generator) -> tuple[np.ndarray, Scenes]:
        """Draw n valid scenes, uniform by rejection: theta [n, D] and its Scenes.

        A soft requirement is in force in its share of the scenes, decided once for each. Raises ScenicError of kind
        `rejection` with the report if no draw is valid, of another if a requirement fails in a scene.
        """
        if n < 0:
            raise ValueError(f"a number of scenes is 0 or more, not {n}")
        soft = [(i, rule.probability) for i, rule in enumerate(self.requirements) if rule.probability < 1]
        active = np.stack([rng.random(n) < p for _, p in soft], axis=1) if soft else np.zeros((n, 0), dtype=bool)
        theta = np.empty((n, self.dim))
        pending = np.arange(n)
        draws = accepted = 0
        self.mode.budget.new_call(n)
        while len(pending):
            if draws >= (FIRST_DRAWS if len(pending) == n else FIRST_DRAWS + DRAWS_PER_SCENE * n):
                raise self._impossible(rng, n - len(pending), n, draws)
            wanted = (draws + 1) // (accepted + 1) + 1 if draws else 1  # so that most of the pending scenes get one
            each = max(1, min(wanted, FIRST_DRAWS // len(pending)))
            candidates = rng.uniform(-1.0, 1.0, (len(pending) * each, self.dim))
            scenes, found_faults = self._scenes(candidates)
            draws += len(candidates)
            in_force = np.ones(scenes.failed.shape, dtype=bool)
            in_force[:, [i for i, _ in soft]] = np.repeat(active[pending], each, axis=0)
            broken = scenes.failed & in_force
            good = (scenes.ok & ~broken.any(axis=1)).reshape(len(pending), each)
            if found_faults.any:
                drawn = good.cumsum(axis=1) <= good  # one by one, up to the first that is good
                found_faults.raise_first(broken, drawn.ravel())
            accepted += int(good.sum())
            found = good.any(axis=1)
            chosen = (np.arange(len(pending)) * each + good.argmax(axis=1))[found]
            theta[pending[found]] = candidates[chosen]
            pending = pending[~found]
        return theta, self.instantiate(theta)

    def report(self, n: int, rng: np.random.Generator) -> RejectionReport:
        """What share of n uniform draws each rule rejects."""
        if n < 1:
            raise ValueError(f"a report needs at least one draw, not {n}")
        scenes = self.instantiate(rng.uniform(-1.0, 1.0, (n, self.dim)))
        shares = scenes.failed.mean(axis=0)
        order = sorted(range(len(shares)), key=lambda i: -shares[i])
        rejected = tuple((self.requirements[i], float(shares[i])) for i in order if shares[i] > 0)
        return RejectionReport(self.file, n, int(scenes.ok.sum()), rejected)

    def _impossible(self, rng: np.random.Generator, found: int, wanted: int, draws: int) -> ScenicError:
        report = replace(self.report(FIRST_DRAWS, rng), accepted=0)
        if not found:
            return ScenicError("rejection", str(report))
        head = f"{self.file}: only {found} of {wanted} scenes found in {draws:,} draws"
        return ScenicError("rejection", "\n".join([head, *report.rules()]))

    def describe(self, theta: np.ndarray) -> dict[str, Any]:
        """The values that one row theta [D] stands for, by name of the draw, in the program's units."""
        with np.errstate(all="ignore"):
            registers = self._shown.run(self._scaled(self._checked(np.asarray(theta, dtype=float)[None])))
        values = {}
        for draw, column in zip(self.draws, self._columns, strict=True):
            value = registers[self._shown.slot(column.shown)][0]
            value = value.item() if hasattr(value, "item") else value
            values[draw.name] = title_of_option(column.options, value) if column.options else value
        return values

    @cached_property
    def _shown(self) -> Tape:
        """The tape of what a person would want to see of each column."""
        return Tape([column.shown for column in self._columns], self._columns, 10**9)

    # ------------------------------------------------------------ from scenes to θ

    def theta(self, scenes: Scenes | Mapping[Any, Any], default: np.ndarray | None = None) -> np.ndarray:
        """The inverse of `instantiate`: the rows of theta [N, D] that describe some scenes, valid or not.

        `scenes` are Scenes, or what a person writes of them: `{"ego": (30, 5), "keeper": (98, 0, 1.57)}`. A key is an
        object (its label, index, class if there is one of it, or `ego`), a parameter or a draw. An object takes
        (x, y), (x, y, heading in radians) or a dict of properties, in which `behavior` takes a dict of arguments; each
        number may be an array [N]. `default` [D] or [N, D] gives the draws that are not decided by this; for Scenes
        it is 0. Raises ScenicError naming the draws left undecided, or the value that cannot be met and why.
        """
        if not isinstance(scenes, Scenes | Mapping):
            raise TypeError(f"scenes are Scenes or a description such as {{'ego': (30, 5)}}, not {scenes!r:.80}")
        if default is not None:
            default = np.clip(self._checked(np.atleast_2d(default)), -1.0, 1.0)
        subject = Subject(self.file, self._instances, self._param_values, self.param_places, self.draws, self._columns)
        if isinstance(scenes, Scenes) and default is None:
            default = np.zeros((1, self.dim))
        try:
            return theta_of(subject, scenes, default)
        except ScenicError as error:
            if error.place is not None:
                error.source_line = self._sources[error.place.file].line(error.place.line)
            raise

    @property
    def areas(self) -> tuple[Area, ...]:
        """The outlines of the workspace and of the regions from which points are drawn."""
        return areas_of(self._workspace, self._points)

    # ------------------------------------------------------------ errors

    def error(self, kind: str, message: str, place: SourceSpan, hint: str = "") -> ScenicError:
        """An error at a place of the program, to be raised by whoever finds it unfit for its purpose."""
        line = self._sources[place.file].line(place.line)
        return ScenicError(kind, message, place, hint=hint, source_line=line)

    def _refuse_impossible(self) -> None:
        """Raise ScenicError for rules that objects without anything random break; and for operations on mixed kinds."""
        probe = np.linspace(-0.9, 0.9, 3)[:, None] * np.ones(self.dim)
        try:
            scenes = self.instantiate(probe)
        except ScenicError:
            raise
        except (TypeError, ValueError, ArithmeticError, LookupError) as fault:
            message = f"the random values of the program do not fit together: {fault}"
            raise self.error("type", message, SourceSpan(self.file, 1, 0, 1, 1)) from None
        fixed = [not any(True for _ in randoms_in(outline_parts(instance))) for instance in self._instances]
        at = 0
        for check in self._checks.batched:
            for offset, members in enumerate(check.members()):
                if all(fixed[i] for i in members) and scenes.failed[0, at + offset]:
                    raise self._broken(check.rules[offset], [self._instances[i] for i in members])
            at += len(check.rules)
        for rule, value in self._checks.nodes:
            if value is False and rule.kind != "require":
                raise self._broken(rule, [])

    def _broken(self, rule: Constraint, members: list[Instance]) -> ScenicError:
        where = ", ".join(f"{title_of(each)} is at {each.properties['position']!r}" for each in members)
        return self.error("value", f"{rule.label} in every scene", rule.place, where)


def place_in_program(column: ThetaColumn, state: LoadState) -> SourceSpan:
    """Where a value is drawn; for a default of a library's class, where its object is made."""
    place, owner = column.place, column.owner
    while state.sources[place.file].library and owner is not None:
        place, owner = owner[0].place, owner[0].owner
    return place


def outline_parts(instance: Instance) -> list[Value]:
    return [instance.properties[name] for name in ("position", "heading", "width", "length", "allowCollisions")]


def in_order(state: LoadState) -> list[Instance]:
    """The ego first, then as created."""
    return sorted(state.objects, key=lambda instance: instance is not state.ego)


def info_of(instance: Instance) -> ObjectInfo:
    behavior = instance.properties["behavior"]
    attached = (None, None) if behavior is None else (behavior.behavior.name, behavior.place)
    classes = tuple(cls.name for cls in instance.cls.lineage())
    return ObjectInfo(instance.name, instance.cls.name, classes, instance.place, *attached)
