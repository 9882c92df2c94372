"""The rules every scene must pass: objects apart, inside their containers, seen where they must be; the program's own.

Spec section 9, step 2. Overlaps and rectangular containers are tested for all objects at once, since they are tested
for every scene; the rest are nodes of the graph. Read next: `program`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.classes import can_see, outline
from scenic_lite.errors import Place, ScenicError
from scenic_lite.frame import Session
from scenic_lite.geometry import rectangles_meet
from scenic_lite.graph import NOT, OR, Random, Value, apply
from scenic_lite.polygons import CLOSENESS
from scenic_lite.regions import Everywhere, RectangularRegion, Region
from scenic_lite.values import Instance


class Rule(NamedTuple):
    """One thing that a scene must satisfy: `label` as the report prints it, and where it comes from."""

    label: str
    place: Place
    kind: str  # "require", "containment", "overlap", "visibility"
    probability: float = 1.0  # below 1: a soft requirement, in force in that share of the scenes


@dataclass(frozen=True, eq=False)
class Outlines:
    """The rectangles of all objects in N scenes, arrays [N, O] or [O] where they never vary."""

    x: Any
    y: Any
    heading: Any
    width: Any
    length: Any

    def of(self, objects: Any) -> tuple[Any, ...]:
        """x, y, heading, width, length of some objects, their index last."""
        return tuple(part[..., objects] for part in (self.x, self.y, self.heading, self.width, self.length))


class Overlaps:
    """Tests every pair of objects that may not overlap."""

    def __init__(self, objects: list[Instance]) -> None:
        pairs = [
            (i, j)
            for j in range(len(objects))
            for i in range(j)
            if objects[i].properties["allowCollisions"] is not True
            and objects[j].properties["allowCollisions"] is not True
        ]
        self.first = np.array([i for i, _ in pairs], dtype=int)
        self.second = np.array([j for _, j in pairs], dtype=int)
        self.rules = [
            Rule(f"{objects[j].title()} overlaps {objects[i].title()}", objects[j].place, "overlap") for i, j in pairs
        ]

    def members(self) -> list[tuple[int, ...]]:
        """The objects that each rule is about."""
        return list(zip(self.first.tolist(), self.second.tolist(), strict=True))

    def fails(self, outlines: Outlines) -> Any:
        """[N, pairs]: whether the two meet. Upright rectangles, the usual case, are compared by their sides."""
        a, b = outlines.of(self.first), outlines.of(self.second)
        if outlines.heading.ndim == 1 and not outlines.heading.any():
            apart_x = np.abs(a[0] - b[0]) > (a[3] + b[3]) / 2
            apart_y = np.abs(a[1] - b[1]) > (a[4] + b[4]) / 2
            return ~(apart_x | apart_y)
        return rectangles_meet(*a, *b)


class Containment:
    """Tests the objects whose container is one fixed rectangle."""

    def __init__(self, region: RectangularRegion, objects: list[Instance], where: list[int], label: str) -> None:
        self.region = region
        self.where = np.array(where, dtype=int)
        self.rules = [Rule(f"{objects[i].title()} leaves {label}", objects[i].place, "containment") for i in where]
        self.half = (region.width / 2 + CLOSENESS, region.length / 2 + CLOSENESS)
        self.axis = (float(np.cos(region.heading)), float(np.sin(region.heading)))

    def members(self) -> list[tuple[int, ...]]:
        """The objects that each rule is about."""
        return [(i,) for i in self.where.tolist()]

    def fails(self, outlines: Outlines) -> Any:
        """[N, objects]: whether a rectangle sticks out, by its extent along the container's axes."""
        x, y, heading, width, length = outlines.of(self.where)
        (c, s), position = self.axis, self.region.position
        dx, dy = x - position.x, y - position.y
        turn_c, turn_s = np.abs(np.cos(heading - self.region.heading)), np.abs(np.sin(heading - self.region.heading))
        across, along = (width * turn_c + length * turn_s) / 2, (width * turn_s + length * turn_c) / 2
        inside = np.abs(dx * c + dy * s) + across <= self.half[0]
        return ~(inside & (np.abs(dy * c - dx * s) + along <= self.half[1]))


class Checks(NamedTuple):
    """All rules of a program in the order of their columns: arrays first, then nodes of the graph."""

    batched: tuple[Overlaps | Containment, ...]
    nodes: tuple[tuple[Rule, Value], ...]  # the node is true where the rule holds

    @property
    def rules(self) -> tuple[Rule, ...]:
        return (*(rule for each in self.batched for rule in each.rules), *(rule for rule, _ in self.nodes))


def checks_of(session: Session, objects: list[Instance]) -> Checks:
    """Every rule that the objects and requirements of a session imply."""
    batched: list[Overlaps | Containment] = []
    nodes: list[tuple[Rule, Value]] = []
    overlaps = Overlaps(objects)
    if overlaps.rules:
        batched.append(overlaps)
    for region, (where, label) in containers(session, objects).items():
        if isinstance(region, RectangularRegion) and region.fixed():
            batched.append(Containment(region, objects, where, label))
            continue
        for i in where:
            rule = Rule(f"{objects[i].title()} leaves {label}", objects[i].place, "containment")
            nodes.append((rule, region.contains_corners(outline(objects[i]))))
    nodes += visibility(session, objects)
    for requirement in session.requirements:
        rule = Rule(requirement.label, requirement.place, "require", requirement.probability)
        nodes.append((rule, requirement.condition))
    return Checks(tuple(batched), tuple(nodes))


def containers(session: Session, objects: list[Instance]) -> dict[Any, tuple[list[int], str]]:
    """The objects that each container must hold: its own region if it has one, else the workspace."""
    result: dict[Any, tuple[list[int], str]] = {}
    for i, instance in enumerate(objects):
        own = instance.properties["regionContainedIn"]
        region = session.workspace if own is None else own
        if region is None or isinstance(region, Everywhere):
            continue
        if not isinstance(region, Region):
            raise ScenicError("type", "regionContainedIn must be a region", instance.place)
        label = "the workspace" if own is None else "its region"
        result.setdefault(region, ([], label))[0].append(i)
    return result


def visibility(session: Session, objects: list[Instance]) -> list[tuple[Rule, Value]]:
    """What the ego must see, unless `requireVisible` is switched off."""
    nodes = []
    for instance in objects:
        wanted = instance.properties["requireVisible"]
        if wanted is False or instance is session.ego or session.ego is None:
            continue
        seen = can_see(session.ego, instance)
        if isinstance(wanted, Random):
            seen = apply(OR, seen, apply(NOT, wanted, kind="truth"), kind="truth")
        rule = Rule(f"{instance.title()} is not visible from {session.ego.title()}", instance.place, "visibility")
        if seen is not True:
            nodes.append((rule, seen))
    return nodes
