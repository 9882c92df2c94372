"""What each specifier gives: `at`, `in`, `ahead of`, `facing` and the rest.

Each function takes the scope, the node and the evaluated operands. Read next: `language.scenic_operators`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import Sight
from scenic_lite.core.types import Instance, LazyValue, RandomChoice, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import as_heading, as_orientation, is_object, vector_of, view_of
from scenic_lite.language.distributions import point_in
from scenic_lite.language.fields import follow
from scenic_lite.language.specifiers import OPTIONAL, REQUIRED, ResolvedSpecifier
from scenic_lite.values.geometry import Vector, angle_between, as_vector, is_scalar, normalised
from scenic_lite.values.graph import Value, apply
from scenic_lite.values.operations import NOT
from scenic_lite.values.regions import Filtered, RectangularRegion, Region, VectorField

POSITION = {"position": REQUIRED}
# For each direction: its unit step, and the property whose half lies between centre and side.
DIRECTIONS = {"left of": (-1, 0), "right of": (1, 0), "ahead of": (0, 1), "behind": (0, -1)}


def optional_heading(scope: Scope) -> str:
    """Return the property that a specifier of the position may bring along: dialect 3 sets the parent's heading."""
    return "parentOrientation" if scope.state.dialect == 3 else "heading"


def placing(
    scope: Scope, node: ast.AST, words: str, place: Vector, heading: Value = None, priority: int = OPTIONAL
) -> ResolvedSpecifier:
    """Return the specifier of a known place, and of a heading unless that is None."""
    values: dict[str, Value] = {"position": place}
    gives = POSITION
    if heading is not None:
        values[optional_heading(scope)] = heading
        gives = POSITION | {optional_heading(scope): priority}
    return ResolvedSpecifier(words, node, gives, lambda self: values)


def ego_of(scope: Scope) -> Instance:
    if scope.state.ego is None:
        raise ScenicError("name", "there is no ego yet", hint="write ego = ... before this line")
    return scope.state.ego


def at(scope: Scope, node: ast.AST, place: Value) -> ResolvedSpecifier:
    if isinstance(place, LazyValue):
        delayed = place
        return ResolvedSpecifier("at", node, POSITION, lambda self: {"position": delayed.compute(self)}, place.needs)
    return placing(scope, node, "at", vector_of(place, "at"))


def inside(scope: Scope, node: ast.AST, region: Value) -> ResolvedSpecifier:
    """`in R` and `on R`: a uniform point, with the region's orientation if it has one.

    In dialect 3 also `on` an object, which is its rectangle, and `on` a point.
    """
    words = node.name  # type: ignore[attr-defined]
    if words == "on" and scope.state.dialect == 3 and not isinstance(region, Region | RandomChoice):
        if is_object(region):
            p = region.properties
            region = RectangularRegion(p["position"], p["heading"], p["width"], p["length"])
        elif as_vector(region) is not None:
            return placing(scope, node, words, vector_of(region, "on"))
    oriented = check_region(words, region)
    point, heading = point_in(scope, node, region)
    priority = 2 if words == "on" and scope.state.dialect == 3 else OPTIONAL
    return placing(scope, node, words, point, heading if oriented else None, priority)


def check_region(words: str, region: Value) -> bool:
    """Return whether a region has an orientation. Raises ScenicError if it is none."""
    options = region.options if isinstance(region, RandomChoice) else (region,)
    for option in options:
        if not isinstance(option, Region):
            hint = f"a place is given by `at`, not by `{words}`" if as_vector(option) is not None else ""
            raise ScenicError("type", f"`{words}` needs a region, not {describe_kind(option)}", hint=hint)
    return all(option.orientation is not None for option in options)


def contained_in(scope: Scope, node: ast.AST, region: Value) -> ResolvedSpecifier:
    specifier = inside(scope, node, region)
    gives = specifier.gives | {"regionContainedIn": REQUIRED}
    return ResolvedSpecifier(
        specifier.name, node, gives, lambda self: specifier.compute(self) | {"regionContainedIn": region}
    )


def beside(scope: Scope, node: ast.AST, anchor: Value, gap: Value = None) -> ResolvedSpecifier:
    """`left of X by D` and its kin. Dialect 2 leaves out X's own extent and takes a random X for a vector."""
    words = node.name  # type: ignore[attr-defined]
    step_x, step_y = DIRECTIONS[words]
    extent = "width" if step_x else "length"
    gap = 0.0 if gap is None else gap
    shift = Vector(gap * abs(step_x), gap * abs(step_y)) if is_scalar(gap) else vector_of(gap, f"{words} ... by")

    def offset(self: Instance, other: Value) -> Vector:
        half = (self.properties[extent] + other) / 2
        if step_x:
            return Vector((half + shift.x) * step_x, shift.y)
        return Vector(shift.x, (half + shift.y) * step_y)

    heading = as_heading(anchor) if isinstance(anchor, Instance | RandomChoice) else None
    if heading is None or (isinstance(anchor, RandomChoice) and scope.state.dialect == 2):
        vector = vector_of(anchor, words)
        return ResolvedSpecifier(
            words,
            node,
            POSITION,
            lambda self: {"position": vector + offset(self, 0.0).rotated(self.properties["heading"])},
            frozenset({extent, "heading"}),
        )
    centre, name = vector_of(anchor, words), optional_heading(scope)
    other = own_extent(anchor, extent) if scope.state.dialect == 3 else 0.0
    return ResolvedSpecifier(
        words,
        node,
        POSITION | {name: OPTIONAL},
        lambda self: {"position": centre + offset(self, other).rotated(heading), name: heading},
        frozenset({extent}),
    )


def own_extent(anchor: Value, extent: str) -> Value:
    """Return the width or length of an object; points have none."""
    if isinstance(anchor, RandomChoice):
        return anchor.map_options([own_extent(option, extent) for option in anchor.options])
    return anchor.properties[extent] if is_object(anchor) else 0.0


def offset_by(scope: Scope, node: ast.AST, offset: Value) -> ResolvedSpecifier:
    ego = ego_of(scope)
    heading = ego.properties["heading"]
    place = ego.properties["position"] + vector_of(offset, "offset by").rotated(heading)
    return at_with_heading(scope, node, place, heading)


def offset_along(scope: Scope, node: ast.AST, direction: Value, offset: Value) -> ResolvedSpecifier:
    ego = ego_of(scope)
    start = ego.properties["position"]
    turn = direction.heading_at(start) if isinstance(direction, VectorField) else as_heading(direction)
    if turn is None:
        raise ScenicError("type", f"`offset along` needs a heading, not {describe_kind(direction)}")
    place = start + vector_of(offset, "offset along ... by").rotated(turn)
    return at_with_heading(scope, node, place, ego.properties["heading"])


def beyond(scope: Scope, node: ast.AST, anchor: Value, gap: Value, viewpoint: Value = None) -> ResolvedSpecifier:
    """`beyond X by D from Y`; in dialect 3 with the heading 0, also where Y has another."""
    viewpoint = ego_of(scope) if viewpoint is None else viewpoint
    far, near_end = vector_of(anchor, "beyond"), vector_of(viewpoint, "beyond ... from")
    shift = Vector(0.0, gap) if is_scalar(gap) else vector_of(gap, "beyond ... by")
    place = far + shift.rotated(angle_between(near_end, far))
    return at_with_heading(scope, node, place, 0.0)


def at_with_heading(scope: Scope, node: ast.AST, place: Vector, heading: Value) -> ResolvedSpecifier:
    """Return the specifier of a place, and in dialect 3 of a parent heading."""
    words = node.name  # type: ignore[attr-defined]
    return placing(scope, node, words, place, heading if scope.state.dialect == 3 else None)


def visible(scope: Scope, node: ast.AST, viewer: Value = None) -> ResolvedSpecifier:
    """`visible [from V]`: a point of V's view; dialect 3 also demands that V sees the object, wherever it is put."""
    viewer = viewer_of(scope, viewer)
    return in_or_out_of_sight(scope, node, Sight(viewer, True), lambda self: view_of(viewer))


def not_visible(scope: Scope, node: ast.AST, viewer: Value = None) -> ResolvedSpecifier:
    """`not visible [from V]`: a point of the container outside V's view; dialect 3 hides all of the object."""
    viewer = viewer_of(scope, viewer)
    view = view_of(viewer)

    def hidden(self: Instance) -> Region:
        container = self.properties["regionContainedIn"] or scope.state.workspace
        if container is None:
            raise ScenicError("value", "`not visible` needs a workspace to draw from")
        return Filtered(container, lambda point: apply(NOT, view.contains(point)))

    return in_or_out_of_sight(scope, node, Sight(viewer, False), hidden)


def in_or_out_of_sight(
    scope: Scope, node: ast.AST, sight: Sight, region_for: Callable[[Instance], Region]
) -> ResolvedSpecifier:
    """Return a position drawn from a region that depends on what can be seen."""
    dialect = scope.state.dialect
    words = "visible" if sight.visible else "not visible"

    def compute(self: Instance) -> dict[str, Value]:
        return {"position": point_in(scope, node, region_for(self))[0]}

    def demand(self: Instance) -> None:
        if dialect == 3:
            scope.state.sights.append((self, sight))

    gives = {"position": OPTIONAL if dialect == 3 else REQUIRED}
    return ResolvedSpecifier(words, node, gives, compute, frozenset({"regionContainedIn"}), demand)


def viewer_of(scope: Scope, viewer: Value) -> Instance:
    if viewer is None:
        return ego_of(scope)
    if not isinstance(viewer, Instance):
        raise ScenicError("type", f"only a Point or an object can see, not {describe_kind(viewer)}")
    return viewer


def following(scope: Scope, node: ast.AST, field: Value, start: Value, distance: Value) -> ResolvedSpecifier:
    start = vector_of(ego_of(scope) if start is None else start, "following ... from")
    end, heading = follow(field, start, distance)
    return placing(scope, node, "following", end, heading)


def facing(scope: Scope, node: ast.AST, direction: Value) -> ResolvedSpecifier:
    if isinstance(direction, VectorField):
        field = direction
        return heading_specifier(scope, node, lambda self: field.heading_at(self.properties["position"]), {"position"})
    if isinstance(direction, LazyValue):
        return heading_specifier(scope, node, direction.compute, direction.needs)
    heading = as_orientation(direction) if scope.state.dialect == 3 else as_heading(direction)
    if heading is None:
        raise ScenicError(
            "type", f"`facing` needs a heading, not {describe_kind(direction)}", hint=facing_hint(direction)
        )
    return heading_specifier(scope, node, lambda self: heading, set())


def facing_hint(value: Value) -> str:
    return "a point is faced by `facing toward`" if as_vector(value) is not None else ""


def facing_toward(scope: Scope, node: ast.AST, target: Value) -> ResolvedSpecifier:
    vector = vector_of(target, "facing toward")
    return heading_specifier(scope, node, lambda self: angle_between(self.properties["position"], vector), {"position"})


def facing_away(scope: Scope, node: ast.AST, target: Value) -> ResolvedSpecifier:
    vector = vector_of(target, "facing away from")
    return heading_specifier(scope, node, lambda self: angle_between(vector, self.properties["position"]), {"position"})


def apparently_facing(scope: Scope, node: ast.AST, turn: Value, viewpoint: Value = None) -> ResolvedSpecifier:
    """Heading `turn` as seen from the viewpoint; dialect 3 sets the yaw, on top of the parent's heading."""
    start = vector_of(ego_of(scope) if viewpoint is None else viewpoint, "apparently facing ... from")
    name = "yaw" if scope.state.dialect == 3 else "heading"

    def compute(self: Instance) -> dict[str, Value]:
        return {name: angle_between(start, self.properties["position"]) + turn}

    return ResolvedSpecifier("apparently facing", node, {name: REQUIRED}, compute, frozenset({"position"}))


def heading_specifier(
    scope: Scope, node: ast.AST, compute: Callable[[Instance], Value], needs: Any
) -> ResolvedSpecifier:
    """Return a required heading; dialect 3 normalises it."""
    finish = normalised if scope.state.dialect == 3 else lambda heading: heading
    return ResolvedSpecifier(
        "facing", node, {"heading": REQUIRED}, lambda self: {"heading": finish(compute(self))}, frozenset(needs)
    )


SPECIFIERS: dict[str, Callable[..., ResolvedSpecifier]] = {
    "at": at,
    "in": inside,
    "on": inside,
    "contained in": contained_in,
    "left of": beside,
    "right of": beside,
    "ahead of": beside,
    "behind": beside,
    "offset by": offset_by,
    "offset along": offset_along,
    "beyond": beyond,
    "visible": visible,
    "not visible": not_visible,
    "following": following,
    "facing": facing,
    "facing toward": facing_toward,
    "facing away from": facing_away,
    "facing directly toward": facing_toward,
    "facing directly away from": facing_away,
    "apparently facing": apparently_facing,
}
