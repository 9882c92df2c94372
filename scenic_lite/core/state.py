"""The state of a load, the handlers of nodes, and the mode in which they are evaluated.

An episode, the compiler and each single scene have their own `Mode`, which is part of the scopes. A running program
replaces nothing in this module. Read next: `core.scope`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from scenic_lite.core.budget import Budget, exceeded
from scenic_lite.core.checks import RuntimeChecks
from scenic_lite.core.types import Behavior, BehaviorCall, Environment, Instance, Namespace, Source, for_each_option
from scenic_lite.core.world import Domain
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, ThetaColumn, Value
from scenic_lite.values.regions import Region

LOAD, SAMPLE, EPISODE, COMPILE = "load", "sample", "episode", "compile"  # phases of a Mode
MOST_BRANCHES = 8  # maximum number of branches on random values in one function


@dataclass
class Requirement:
    """One `require` statement with its condition over the samples."""

    label: str
    place: SourceSpan
    condition: Value
    probability: float = 1.0


class DrawnPoint(NamedTuple):
    """A point drawn from a region, and the columns of θ that determine the point; the region has the inverse map.

    `whole` is the region in the program if the point is drawn from only a part of it.
    """

    region: Region
    columns: tuple[ThetaColumn, ...]
    point: Vector
    whole: Region | None = None


class VisibilityDemand(NamedTuple):
    """The demand of an object's specifier that `viewer` sees the object, or does not see it."""

    viewer: Instance
    visible: bool


class EpisodeStatement(NamedTuple):
    """A statement about the whole episode, with its visible names: `terminate`, `record`, `require always`."""

    tree: Any  # nodes.TerminateWhen, TerminateAfter, Record or Require
    place: SourceSpan
    scope: Environment
    label: str = ""  # its name, or its source text
    bindings: Any = None  # `Bindings` of a requirement, which keep the values of its names
    duration: Value = None  # of a `terminate after`; draws in the program's own one are columns of θ


@dataclass(eq=False)
class LoadState:
    """Everything that the statements of one program have created so far."""

    domain: Domain | None
    dialect: int
    budget: Budget = field(default_factory=Budget)
    objects: list[Instance] = field(default_factory=list)
    params: dict[str, Value] = field(default_factory=dict)
    requirements: list[Requirement] = field(default_factory=list)
    visibility_demands: list[tuple[Instance, VisibilityDemand]] = field(default_factory=list)
    conditions: list[Callable[[], None]] = field(default_factory=list)  # callbacks that evaluate the requirements again
    columns: list[ThetaColumn] = field(default_factory=list)
    points: list[DrawnPoint] = field(default_factory=list)
    behaviors: dict[str, Behavior] = field(default_factory=dict)
    monitors: list[BehaviorCall] = field(default_factory=list)
    terminations: list[EpisodeStatement] = field(default_factory=list)
    records: list[EpisodeStatement] = field(default_factory=list)
    temporal: list[EpisodeStatement] = field(default_factory=list)
    scenarios: list[Behavior] = field(default_factory=list)
    main: BehaviorCall | None = None  # the call of the main modular scenario
    main_frame: Environment | None = None
    library_params: set[str] = field(default_factory=set)
    param_places: dict[str, SourceSpan] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    modules: dict[str, Namespace] = field(default_factory=dict)
    importing: list[str] = field(default_factory=list)
    root: Path | None = None  # the program's folder
    model: str | None = None  # the world model that replaces the program's
    fixed_params: frozenset[str] = frozenset()  # set by the caller; the program cannot change them
    warnings: list[ScenicError] = field(default_factory=list)
    printed: list[str] = field(default_factory=list)
    diagnostics: list[ScenicError] = field(default_factory=list)  # warnings of the parser
    watching: RuntimeChecks = field(default_factory=RuntimeChecks)
    ego: Instance | None = None
    workspace: Value = None

    def column(self, kind: str, place: SourceSpan, offset: float = 0.0, span: float = 1.0) -> ThetaColumn:
        """Draw a new random value: one more column of θ."""
        if len(self.columns) >= self.budget.limits.draws:
            raise exceeded(f"more than {self.budget.limits.draws:,} random values are drawn")
        self.columns.append(ThetaColumn(kind, place, offset, span))
        return self.columns[-1]

    @contextmanager
    def with_location(self, place: SourceSpan | None) -> Iterator[None]:
        """Set the place of an error that is raised inside the context without a place."""
        try:
            yield
        except ScenicError as error:
            if error.place is None and place is not None:
                error.place = place
                error.source_line = self.sources[place.file].line(place.line)
            raise

    def clear_episode_statements(self) -> None:
        """Start new lists of episode statements, since later statements belong to another scenario."""
        self.monitors, self.terminations, self.records, self.temporal = [], [], [], []

    def copy_to_play(self) -> LoadState:
        """Return a state for one episode or compilation; its statements do not change the program's state."""
        copy = replace(
            self,
            points=[],
            requirements=[],
            scenarios=list(self.scenarios),
            behaviors=dict(self.behaviors),
            watching=RuntimeChecks(),
        )
        copy.clear_episode_statements()
        return copy

    @contextmanager
    def own_ego(self) -> Iterator[None]:
        """Hide the ego while a module is loaded; a program of dialect 3 without an ego takes the module's."""
        before, self.ego = self.ego, None
        try:
            yield
        finally:
            self.ego = before if before is not None or self.dialect == 2 else self.ego


@dataclass(frozen=True)
class Handlers:
    """The implementation of each type of node, and the built-in names of the language."""

    expressions: dict[type, Callable[..., Value]]  # (scope, node) -> value
    statements: dict[type, Callable[..., Any]]  # (scope, node)
    builtins: dict[str, Value]
    call: Callable[..., Value]  # (scope, function, arguments, keywords, node) -> value
    unpack: Callable[..., None]  # (scope, target, value)
    undecided: Callable[..., Value] = for_each_option  # (function, index of the undecided value, arguments, keywords)


@dataclass(frozen=True, eq=False)
class Mode:
    """The mode of evaluation: while a program is loaded, in one sample, in an episode, or by the compiler.

    Attributes:
        phase: LOAD, SAMPLE, EPISODE or COMPILE.
        state: receives what statements create.
        budget: counts every step.
        draw: returns a new random value (kind, place, offset, span).
        symbolic: whether comparisons and `and`, `or`, `not` of random values give values instead of errors.
        row: the value of each random node, in one sample.
        path: the branches taken, in a function that branches on random values.
        owner: the object and the property whose specifier is being evaluated; they name the draws.
        in_model: whether a `model` statement is being executed; params of a model are only defaults.
    """

    phase: str
    state: LoadState
    handlers: Handlers
    budget: Budget
    draw: Callable[[str, SourceSpan, float, float], ThetaColumn]
    symbolic: bool = False
    row: dict[RandomExpr, Value] | None = None
    path: BranchPath | None = None
    owner: tuple[Instance, str] | None = None
    in_model: bool = False

    def requiring(self) -> Mode:
        """Return the mode inside a requirement, with symbolic comparisons and without draws."""
        return self if self.symbolic else replace(self, symbolic=True, draw=refuse_draw)

    def with_owner(self, instance: Instance, name: str) -> Mode:
        """Return this mode with draws that belong to `instance.name`."""
        mode = object.__new__(Mode)  # `replace` is ten times slower, and this runs for every property
        vars(mode).update(vars(self), owner=(instance, name))
        return mode

    def in_sample(self, row: dict[RandomExpr, Value], budget: Budget) -> Mode:
        """Return the mode inside a requirement in one sample."""
        return replace(self.requiring(), phase=SAMPLE, row=row, budget=budget)


def refuse_draw(*_: Any) -> ThetaColumn:
    hint = "draw it before the requirement and give it a name"
    raise ScenicError("type", "a requirement cannot draw a random value", hint=hint)


class BranchPath:
    """One path through a function that branches on random values: given decisions, then always True; its conditions."""

    def __init__(self, decisions: list[bool]) -> None:
        self.decisions = decisions
        self.conditions: list[Value] = []

    def branch(self, condition: Value) -> bool:
        """Record the condition of the next branch and return the decision."""
        if len(self.conditions) >= MOST_BRANCHES:
            message = f"a field's function decides on its point more than {MOST_BRANCHES} times"
            raise ScenicError("random-control-flow", message, hint="write a formula, or a field for each region")
        self.conditions.append(condition)
        self.decisions += [True] * (len(self.conditions) - len(self.decisions))
        return self.decisions[len(self.conditions) - 1]
