"""What loading a program collects, what nodes mean, and the mode in which they are evaluated.

Nothing here is exchanged while a program runs: an episode, the compiler and each single scene have a `Mode` of their
own, which the scopes carry. Read next: `core.scope`.
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
MOST_BRANCHES = 8  # on random values, of one function


@dataclass
class Requirement:
    """One `require`: its condition over the samples."""

    label: str
    place: SourceSpan
    condition: Value
    probability: float = 1.0


class DrawnPoint(NamedTuple):
    """A point drawn from one region, and the columns of θ that it was made of: how to go back is the region's.

    `whole` is the region that the program names, where only a part of it is drawn from.
    """

    region: Region
    columns: tuple[ThetaColumn, ...]
    point: Vector
    whole: Region | None = None


class VisibilityDemand(NamedTuple):
    """What an object's specifier demands: that `viewer` sees it, or that it does not."""

    viewer: Instance
    visible: bool


class EpisodeStatement(NamedTuple):
    """A statement that is about the whole episode, with the names it sees: `terminate`, `record`, `require always`."""

    tree: Any  # nodes.TerminateWhen, TerminateAfter, Record or Require
    place: SourceSpan
    scope: Environment
    label: str = ""  # its name, or its text
    bindings: Any = None  # `Bindings` of a requirement, which means its names as they were
    duration: Value = None  # of a `terminate after`; if it is the program's own, draws are columns of θ


@dataclass(eq=False)
class LoadState:
    """Everything that the statements of one program have made so far."""

    domain: Domain | None
    dialect: int
    budget: Budget = field(default_factory=Budget)
    objects: list[Instance] = field(default_factory=list)
    params: dict[str, Value] = field(default_factory=dict)
    requirements: list[Requirement] = field(default_factory=list)
    visibility_demands: list[tuple[Instance, VisibilityDemand]] = field(default_factory=list)
    conditions: list[Callable[[], None]] = field(default_factory=list)  # evaluate the requirements again
    columns: list[ThetaColumn] = field(default_factory=list)
    points: list[DrawnPoint] = field(default_factory=list)
    behaviors: dict[str, Behavior] = field(default_factory=dict)
    monitors: list[BehaviorCall] = field(default_factory=list)
    terminations: list[EpisodeStatement] = field(default_factory=list)
    records: list[EpisodeStatement] = field(default_factory=list)
    temporal: list[EpisodeStatement] = field(default_factory=list)
    scenarios: list[Behavior] = field(default_factory=list)
    main: BehaviorCall | None = None  # the modular scenario that the program is
    main_frame: Environment | None = None
    library_params: set[str] = field(default_factory=set)
    param_places: dict[str, SourceSpan] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    modules: dict[str, Namespace] = field(default_factory=dict)
    importing: list[str] = field(default_factory=list)
    root: Path | None = None  # the program's folder
    model: str | None = None  # the world model that the caller wants instead of the program's
    fixed_params: frozenset[str] = frozenset()  # set by the caller, whatever the program says
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
        """Give an error that is raised inside without a place of its own this one."""
        try:
            yield
        except ScenicError as error:
            if error.place is None and place is not None:
                error.place = place
                error.source_line = self.sources[place.file].line(place.line)
            raise

    def clear_episode_statements(self) -> None:
        """Begin new lists of what is watched in episodes: what follows belongs to another scenario."""
        self.monitors, self.terminations, self.records, self.temporal = [], [], [], []

    def copy_to_play(self) -> LoadState:
        """Return a state for one episode or compilation: what its statements make is its own, not the program's."""
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
        """Have no ego inside, for a module; the one that it sets is the program's where that has none (dialect 3)."""
        before, self.ego = self.ego, None
        try:
            yield
        finally:
            self.ego = before if before is not None or self.dialect == 2 else self.ego


@dataclass(frozen=True)
class Handlers:
    """What each type of node means, and what names mean that no program defines."""

    expressions: dict[type, Callable[..., Value]]  # (scope, node) -> value
    statements: dict[type, Callable[..., Any]]  # (scope, node)
    builtins: dict[str, Value]
    call: Callable[..., Value]  # (scope, function, arguments, keywords, node) -> value
    unpack: Callable[..., None]  # (scope, target, value)
    undecided: Callable[..., Value] = for_each_option  # (function, place of what is undecided, arguments, keywords)


@dataclass(frozen=True, eq=False)
class Mode:
    """How nodes are evaluated: while a program is loaded, in one sample of it, in an episode, for the compiler.

    Attributes:
        phase: one of these four.
        state: where statements put what they make.
        budget: of which every step is paid.
        draw: gives a new random value (kind, place, offset, span).
        symbolic: comparisons and `and`, `or`, `not` of random values are values, not errors.
        row: in one sample, what each random node is there.
        path: where a function branches on random values, the branches that are taken.
        owner: the object and the property whose specifier is evaluated, which names the draws.
        in_model: a `model` statement is executed, whose params are only defaults.
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
        """Return the mode inside a requirement, where comparisons are symbolic and nothing can be drawn."""
        return self if self.symbolic else replace(self, symbolic=True, draw=refuse_draw)

    def with_owner(self, instance: Instance, name: str) -> Mode:
        """Return the mode in which the values that are drawn belong to `instance.name`."""
        mode = object.__new__(Mode)  # `replace` is ten times slower, and this is done for every property
        vars(mode).update(vars(self), owner=(instance, name))
        return mode

    def in_sample(self, row: dict[RandomExpr, Value], budget: Budget) -> Mode:
        """Return the mode inside a requirement in one sample."""
        return replace(self.requiring(), phase=SAMPLE, row=row, budget=budget)


def refuse_draw(*_: Any) -> ThetaColumn:
    hint = "draw it before the requirement and give it a name"
    raise ScenicError("type", "a requirement cannot draw a random value", hint=hint)


class BranchPath:
    """One way through a function that branches on random values: its decisions, then always True; what each asked."""

    def __init__(self, decisions: list[bool]) -> None:
        self.decisions = decisions
        self.conditions: list[Value] = []

    def branch(self, condition: Value) -> bool:
        """Return which way to go at the next branch."""
        if len(self.conditions) >= MOST_BRANCHES:
            message = f"a field's function decides on its point more than {MOST_BRANCHES} times"
            raise ScenicError("random-control-flow", message, hint="write a formula, or a field for each region")
        self.conditions.append(condition)
        self.decisions += [True] * (len(self.conditions) - len(self.decisions))
        return self.decisions[len(self.conditions) - 1]
