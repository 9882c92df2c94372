"""The constraints of every scene: no overlaps, containment, visibility, and the program's requirements.

Overlaps and rectangular containers are tested for all objects at once, since every scene needs these tests. All other
constraints are nodes of the graph. Read next: `scene.program`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.state import LoadState, VisibilityDemand
from scenic_lite.core.types import Instance
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.language.classes import can_see, outline, rectangle_of
from scenic_lite.values.formulas import CLOSENESS, rectangles_meet
from scenic_lite.values.graph import RandomExpr, Tape, Value, apply
from scenic_lite.values.operations import NOT, OR, RECTANGLES_MEET
from scenic_lite.values.regions import Everywhere, RectangularRegion, Region

BLOCK = 8192  # size of one array in constraint tests, in numbers
SHOWN = 8  # maximum number of constraints in a report, in order of decreasing share


class Constraint(NamedTuple):
    """One condition on a scene, with its `label` in the report and its origin."""

    label: str
    place: SourceSpan
    kind: str  # "require", "containment", "overlap", "visibility"
    probability: float = 1.0  # below 1: a soft requirement, active in this share of the scenes


@dataclass(frozen=True, eq=False)
class Outlines:
    """The rectangles of all objects in N scenes: arrays [O, N], or [O, 1] if they are constant.

    Objects are the first axis, so that the values of one object or one constraint are contiguous.
    """

    x: Any
    y: Any
    heading: Any
    width: Any
    length: Any

    def of(self, objects: Any) -> tuple[Any, ...]:
        """Return x, y, heading, width, length of the selected objects."""
        return tuple(part[objects] for part in (self.x, self.y, self.heading, self.width, self.length))


@dataclass(frozen=True, eq=False)
class BatchedTest:
    """K constraints of one kind, tested for all objects at once.

    Attributes:
        constraints: the K constraints.
        members: for each object of a constraint (such as the first of a pair), an array [K] of object indices.
        violated: the test, from x, y, heading, width, length of each member, arrays [k, N], to booleans [k, N].
    """

    constraints: list[Constraint]
    members: tuple[np.ndarray, ...]
    violated: Callable[..., Any]

    def fails(self, outlines: Outlines) -> Any:
        """Return the violated constraints, [K, N] bool; computed in blocks that fit into the processor's cache."""
        size = max(1, BLOCK // max(1, outlines.x.shape[1]))
        parts = []
        for start in range(0, len(self.constraints), size):
            some = (outlines.of(member[start : start + size]) for member in self.members)
            parts.append(self.violated(*chain.from_iterable(some)))
        return parts[0] if len(parts) == 1 else np.concatenate(parts)


def overlaps_of(objects: list[Instance]) -> BatchedTest | None:
    """Return the test of all pairs of objects that must not overlap."""
    strict = [i for i, instance in enumerate(objects) if instance.properties["allowCollisions"] is False]
    pairs = np.array([(i, j) for j in strict for i in strict if i < j], dtype=int).reshape(-1, 2)
    constraints = [
        Constraint(f"{objects[j].title()} overlaps {objects[i].title()}", objects[j].place, "overlap") for i, j in pairs
    ]
    return BatchedTest(constraints, tuple(pairs.T), meet) if constraints else None


def meet(*numbers: Any) -> Any:
    """Return whether rectangles meet; `rectangles_meet` is called only for pairs whose circumscribed circles meet."""
    ax, ay, heading_a, width_a, length_a, bx, by, heading_b, width_b, length_b = numbers
    if heading_a.shape[1] == 1 and not heading_a.any() and not heading_b.any():  # axis-aligned, the most frequent case
        return (np.abs(ax - bx) <= (width_a + width_b) / 2) & (np.abs(ay - by) <= (length_a + length_b) / 2)
    dx, dy = ax - bx, ay - by
    reach = (np.hypot(width_a, length_a) + np.hypot(width_b, length_b)) * (0.5 + 1e-9)
    meets = dx * dx + dy * dy <= reach * reach
    near = np.nonzero(meets)
    if len(near[0]):
        meets[near] = rectangles_meet(*(np.broadcast_to(part, meets.shape)[near] for part in numbers))
    return meets


def containment_of(region: RectangularRegion, where: list[int], constraints: list[Constraint]) -> BatchedTest:
    """Return the test of the objects whose container is one fixed rectangle."""
    c, s, position = float(np.cos(region.heading)), float(np.sin(region.heading)), region.position
    half_width, half_length = region.width / 2 + CLOSENESS, region.length / 2 + CLOSENESS

    def sticks_out(x: Any, y: Any, heading: Any, width: Any, length: Any) -> Any:
        """Return whether a rectangle leaves its container, from its extent along the container's axes."""
        dx, dy = x - position.x, y - position.y
        turn_c, turn_s = np.abs(np.cos(heading - region.heading)), np.abs(np.sin(heading - region.heading))
        across, along = (width * turn_c + length * turn_s) / 2, (width * turn_s + length * turn_c) / 2
        inside = np.abs(dx * c + dy * s) + across <= half_width
        return ~(inside & (np.abs(dy * c - dx * s) + along <= half_length))

    return BatchedTest(constraints, (np.array(where, dtype=int),), sticks_out)


class Constraints:
    """All R constraints of a program: first the batched tests, then the nodes of the graph."""

    def __init__(self, batched: list[BatchedTest], nodes: list[tuple[Constraint, Value]]) -> None:
        """Create from batched tests and from nodes; a node is true if its constraint holds."""
        self.batched, self.nodes = batched, nodes
        self.all = (
            *(constraint for test in batched for constraint in test.constraints),
            *(constraint for constraint, _ in nodes),
        )
        hard = [i for i, constraint in enumerate(self.all) if constraint.probability == 1]
        # rows of failed [R, N] whose constraints are active in every scene
        self.hard: Any = ... if len(hard) == len(self.all) else np.array(hard, dtype=int)
        self._slots: list[bool | int] = []

    def read_from(self, tape: Tape) -> None:
        """Find the nodes' registers on a tape."""
        self._slots = [tape.slot(value) if isinstance(value, RandomExpr) else bool(value) for _, value in self.nodes]

    def failed(self, registers: list[Any], outlines: Outlines, count: int) -> np.ndarray:
        """Return the violated constraints: [R, N] bool."""
        failed = np.empty((len(self.all), count), dtype=bool)
        at = 0
        for test in self.batched:
            failed[at : at + len(test.constraints)] = test.fails(outlines)
            at += len(test.constraints)
        for i, slot in enumerate(self._slots):
            failed[at + i] = (not slot) if isinstance(slot, bool) else np.logical_not(registers[slot])
        return failed

    def members(self) -> Iterator[tuple[Constraint, tuple[int, ...]]]:
        """Yield the constraints of batched tests with the indices of their objects."""
        for test in self.batched:
            yield from zip(test.constraints, zip(*test.members, strict=True), strict=True)


def constraints_of(state: LoadState, objects: list[Instance]) -> Constraints:
    """Return all constraints that follow from the objects and requirements of a program."""
    nodes: list[tuple[Constraint, Value]] = []
    overlaps = overlaps_of(objects)
    batched = [] if overlaps is None else [overlaps]
    for region, (where, label) in containers(state, objects).items():
        held = [objects[i] for i in where]
        stays = [Constraint(f"{one.title()} leaves {label}", one.place, "containment") for one in held]
        if isinstance(region, RectangularRegion) and region.fixed():
            batched.append(containment_of(region, where, stays))
        else:
            nodes += [(stay, region.contains_corners(outline(one))) for stay, one in zip(stays, held, strict=True)]
    nodes += [*sometimes_apart(objects), *visibility(state, objects)]
    for requirement in state.requirements:
        if requirement.condition is not True:
            constraint = Constraint(requirement.label, requirement.place, "require", requirement.probability)
            nodes.append((constraint, requirement.condition))
    return Constraints(batched, nodes)


def constraint_of_requirement(state: LoadState, constraints: Constraints) -> list[int | None]:
    """Return the constraint index of each requirement; None for a requirement that always holds."""
    at = len(constraints.all) - sum(requirement.condition is not True for requirement in state.requirements)
    numbers: list[int | None] = []
    for requirement in state.requirements:
        numbers.append(None if requirement.condition is True else at)
        at += requirement.condition is not True
    return numbers


def containers(state: LoadState, objects: list[Instance]) -> dict[Any, tuple[list[int], str]]:
    """Return the objects and the label of each container: the object's own region, or by default the workspace."""
    result: dict[Any, tuple[list[int], str]] = {}
    for i, instance in enumerate(objects):
        own = instance.properties["regionContainedIn"]
        region = state.workspace if own is None else own
        if region is None or isinstance(region, Everywhere):
            continue
        if not isinstance(region, Region):
            raise ScenicError("type", "regionContainedIn must be a region", instance.place)
        label = "the workspace" if own is None else "its region"
        result.setdefault(region, ([], label))[0].append(i)
    return result


def sometimes_apart(objects: list[Instance]) -> Iterator[tuple[Constraint, Value]]:
    """Yield the overlap constraints of pairs in which an object allows collisions in some scenes only."""
    for j, b in enumerate(objects):
        for a in objects[:j]:
            allowed = [instance.properties["allowCollisions"] for instance in (a, b)]
            if any(isinstance(value, RandomExpr) for value in allowed) and True not in allowed:
                meets = apply(RECTANGLES_MEET, *rectangle_of(a), *rectangle_of(b))
                excused = apply(OR, *allowed)
                constraint = Constraint(f"{b.title()} overlaps {a.title()}", b.place, "overlap")
                yield constraint, apply(OR, excused, apply(NOT, meets))


def visibility(state: LoadState, objects: list[Instance]) -> Iterator[tuple[Constraint, Value]]:
    """Yield the demands of `requireVisible` on the ego, and of the specifiers `visible` and `not visible`."""
    made = {id(instance) for instance in objects}
    demands = [(instance, sight, True) for instance, sight in state.visibility_demands if id(instance) in made]
    if state.ego is not None:
        others = (instance for instance in objects if instance is not state.ego)
        demands = [
            *((one, VisibilityDemand(state.ego, True), one.properties["requireVisible"]) for one in others),
            *demands,
        ]
    for instance, (viewer, visible), required in demands:
        seen = can_see(viewer, instance, state.dialect) if required is not False else visible
        holds = seen if visible else apply(NOT, seen)
        if isinstance(required, RandomExpr):
            holds = apply(OR, holds, apply(NOT, required))
        if holds is not True:
            label = f"{instance.title()} is {'not ' if visible else ''}visible from {viewer.title()}"
            yield Constraint(label, instance.place, "visibility"), holds


# ------------------------------------------------------------ the report
def percent(share: float) -> str:
    """Return a share in percent, with one decimal unless it is zero: 100%, 50.2%, <0.1%."""
    if 0 < share < 0.001:
        return "<0.1%"
    if 0.999 < share < 1:
        return ">99.9%"
    return f"{100 * share:.1f}".removesuffix(".0") + "%"


@dataclass(frozen=True)
class RejectionReport:
    """The number of valid θ among uniform draws, and the share of draws that each constraint rejects by itself.

    A draw may violate several constraints, so the shares may sum to more than the share of rejected draws.
    """

    file: str
    draws: int
    accepted: int
    rejected: tuple[tuple[Constraint, float], ...]  # only constraints that rejected a draw, by decreasing share

    @property
    def acceptance(self) -> float:
        """Return the share of valid draws."""
        return self.accepted / self.draws

    def __str__(self) -> str:
        if self.accepted:
            head = f"{self.file}: {percent(self.acceptance)} of {self.draws} draws are valid"
        else:
            head = f"{self.file}: no valid scene in {self.draws} draws"
        return "\n".join([head, *self.lines()])

    def lines(self) -> list[str]:
        """Return one line for each constraint that rejected a draw."""
        rows = [
            (f"    line {constraint.place.line}: {constraint.label}", share)
            for constraint, share in self.rejected[:SHOWN]
        ]
        width = max((len(text) for text, _ in rows), default=0) + 6
        lines = [f"{text:<{width}}rejected {percent(share)}" for text, share in rows]
        if len(self.rejected) > SHOWN:
            lines.append(f"    and {len(self.rejected) - SHOWN} more")
        if any(constraint.probability < 1 for constraint, _ in self.rejected):
            lines.append("    (a soft requirement rejects in its share of the scenes only, and makes no draw invalid)")
        return lines
