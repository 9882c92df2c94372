"""The meaning of each specifier: `at`, `in`, `ahead of`, `facing` and others.

Each function takes the scope, the node and the evaluated operands. Read next: `language.scenic_operators`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import VisibilityDemand
from scenic_lite.core.types import Instance, LazyValue, RandomChoice, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.language import classes
from scenic_lite.language.distributions import point_in
from scenic_lite.language.fields import follow
from scenic_lite.language.specifiers import MODIFYING, OPTIONAL, REQUIRED, Given, ResolvedSpecifier
from scenic_lite.values.geometry import Vector, angle_between, as_vector, is_scalar, normalized
from scenic_lite.values.graph import Value
from scenic_lite.values.polygons import outside
from scenic_lite.values.regions import RectangularRegion, Region, VectorField

# The unit step of each direction; along x the extent is the object's width, along y its length.
DIRECTIONS = {"left of": (-1, 0), "right of": (1, 0), "ahead of": (0, 1), "behind": (0, -1)}


def ego_of(scope: Scope) -> Instance:
    if scope.state.ego is None:
        raise ScenicError("name", "there is no ego yet", hint="write ego = ... before this line")
    return scope.state.ego


def or_ego(scope: Scope, value: Value) -> Value:
    """Return an operand; the ego if the operand is omitted."""
    return ego_of(scope) if value is None else value


def viewer_of(scope: Scope, viewer: Value) -> Instance:
    viewer = or_ego(scope, viewer)
    if not isinstance(viewer, Instance):
        raise ScenicError("type", f"only a Point or an object can see, not {describe_kind(viewer)}")
    return viewer


def location_specifier(
    scope: Scope, node: ast.AST, place: Value, heading: Value = None, priority: int = OPTIONAL
) -> ResolvedSpecifier:
    """Return the specifier of a position and, unless it is None, a heading (in dialect 3 the parent's heading)."""
    gives = {"position": Given(REQUIRED, place)}
    if heading is not None:
        gives["parentOrientation" if scope.state.dialect == 3 else "heading"] = Given(priority, heading)
    return ResolvedSpecifier(words_of(node), node, gives)


def words_of(node: ast.AST) -> str:
    return node.name  # type: ignore[attr-defined]


def at(scope: Scope, node: ast.AST, place: Value) -> ResolvedSpecifier:
    return location_specifier(scope, node, place if isinstance(place, LazyValue) else classes.vector_of(place, "at"))


def inside(scope: Scope, node: ast.AST, region: Value) -> ResolvedSpecifier:
    """Return the specifier `in R` or `on R`: a uniform point, with the region's orientation if it has one.

    In dialect 3, `on` also accepts an object, meaning its rectangle, and a point.
    """
    words = words_of(node)
    on = words == "on" and scope.state.dialect == 3
    if on and not isinstance(region, Region | RandomChoice):
        if classes.is_object(region):
            region = RectangularRegion(region.properties["position"], *classes.rectangle_of(region)[2:])
        elif as_vector(region) is not None:
            return location_specifier(scope, node, classes.vector_of(region, "on"))
    oriented = check_region(words, region)
    point, heading = point_in(scope, node, region)
    return location_specifier(scope, node, point, heading if oriented else None, MODIFYING if on else OPTIONAL)


def check_region(words: str, region: Value) -> bool:
    """Return whether a region has an orientation. Raises ScenicError if the value is not a region."""
    options = region.options if isinstance(region, RandomChoice) else (region,)
    for option in options:
        hint = f"a place is given by `at`, not by `{words}`" if as_vector(option) is not None else ""
        classes.needed(words, "a region", option, option if isinstance(option, Region) else None, hint)
    return all(option.orientation is not None for option in options)


def contained_in(scope: Scope, node: ast.AST, region: Value) -> ResolvedSpecifier:
    specifier = inside(scope, node, region)
    return replace(specifier, gives=specifier.gives | {"regionContainedIn": Given(REQUIRED, region)})


def beside(scope: Scope, node: ast.AST, anchor: Value, gap: Value = None) -> ResolvedSpecifier:
    """Return `left of X by D` or another direction. Dialect 2 ignores X's extent and treats a random X as a vector."""
    words = words_of(node)
    step_x, step_y = DIRECTIONS[words]
    extent = "width" if step_x else "length"
    gap = 0.0 if gap is None else gap
    along = Vector(gap * abs(step_x), gap * abs(step_y)) if is_scalar(gap) else None
    shift = classes.vector_of(gap, f"{words} ... by") if along is None else along

    def offset(self: Instance, other: Value) -> Vector:
        half = (self.properties[extent] + other) / 2
        if step_x:
            return Vector((half + shift.x) * step_x, shift.y)
        return Vector(shift.x, (half + shift.y) * step_y)

    heading = classes.as_heading(anchor) if isinstance(anchor, Instance | RandomChoice) else None
    center = classes.vector_of(anchor, words)
    if heading is None or (isinstance(anchor, RandomChoice) and scope.state.dialect == 2):
        place = LazyValue(
            frozenset({extent, "heading"}),
            lambda self: center + offset(self, 0.0).rotated(self.properties["heading"]),
        )
        return location_specifier(scope, node, place)
    other = own_extent(anchor, extent) if scope.state.dialect == 3 else 0.0
    place = LazyValue(frozenset({extent}), lambda self: center + offset(self, other).rotated(heading))
    return location_specifier(scope, node, place, heading)


def own_extent(anchor: Value, extent: str) -> Value:
    """Return the width or length of an object; 0 for a point."""
    if isinstance(anchor, RandomChoice):
        return anchor.each(lambda option: own_extent(option, extent))
    return anchor.properties[extent] if classes.is_object(anchor) else 0.0


def offset_by(scope: Scope, node: ast.AST, offset: Value) -> ResolvedSpecifier:
    return offset_along(scope, node, ego_of(scope), offset, "offset by")


def offset_along(
    scope: Scope, node: ast.AST, direction: Value, offset: Value, words: str = "offset along ... by"
) -> ResolvedSpecifier:
    ego = ego_of(scope)
    place = moved_along(ego.properties["position"], direction, offset, words)
    return at_with_heading(scope, node, place, ego.properties["heading"])


def moved_along(start: Vector, direction: Value, offset: Value, words: str = "offset along ... by") -> Vector:
    """Return `start` plus an offset in the frame of a heading, or of a field's heading at `start`."""
    field = isinstance(direction, VectorField)
    turn = direction.heading_at(start) if field else classes.heading_of(direction, "offset along")
    return start + classes.vector_of(offset, words).rotated(turn)


def beyond(scope: Scope, node: ast.AST, anchor: Value, gap: Value, viewpoint: Value = None) -> ResolvedSpecifier:
    """Return the specifier `beyond X by D from Y`; in dialect 3 the parent heading is 0, whatever Y's heading."""
    viewpoint = or_ego(scope, viewpoint)
    far, near_end = classes.vector_of(anchor, "beyond"), classes.vector_of(viewpoint, "beyond ... from")
    shift = Vector(0.0, gap) if is_scalar(gap) else classes.vector_of(gap, "beyond ... by")
    return at_with_heading(scope, node, far + shift.rotated(angle_between(near_end, far)), 0.0)


def at_with_heading(scope: Scope, node: ast.AST, place: Vector, heading: Value) -> ResolvedSpecifier:
    """Return the specifier of a position and, in dialect 3, of a parent heading."""
    return location_specifier(scope, node, place, heading if scope.state.dialect == 3 else None)


def in_or_out_of_sight(scope: Scope, node: ast.AST, viewer: Value = None) -> ResolvedSpecifier:
    """Return `visible [from V]`: a point in V's view, or `not visible [from V]`: a container point outside V's view.

    Dialect 3 also requires that V sees the object, or sees no part of it, at the final position of the object.
    """
    sight, dialect = VisibilityDemand(viewer_of(scope, viewer), words_of(node) == "visible"), scope.state.dialect
    view = classes.view_of(sight.viewer)

    def place(self: Instance) -> Vector:
        container = self.properties["regionContainedIn"] or scope.state.workspace
        if not sight.visible and container is None:
            raise ScenicError("value", "`not visible` needs a workspace to draw from")
        return point_in(scope, node, view if sight.visible else outside(container, view))[0]

    def demand(self: Instance) -> None:
        if dialect == 3:
            scope.state.visibility_demands.append((self, sight))

    needs = frozenset({"regionContainedIn"})
    gives = {"position": Given(OPTIONAL if dialect == 3 else REQUIRED, LazyValue(needs, place))}
    return ResolvedSpecifier(words_of(node), node, gives, demand)


def following(scope: Scope, node: ast.AST, field: Value, start: Value, distance: Value) -> ResolvedSpecifier:
    end, heading = follow(field, classes.vector_of(or_ego(scope, start), "following ... from"), distance)
    return location_specifier(scope, node, end, heading)


# ------------------------------------------------------------ headings
def at_position(heading_at: Callable[[Vector], Value]) -> LazyValue:
    """Return a heading that depends on the object's position."""
    return LazyValue(frozenset({"position"}), lambda self: heading_at(self.properties["position"]))


def facing(scope: Scope, node: ast.AST, direction: Value) -> ResolvedSpecifier:
    """Return the specifier `facing H`: a required heading in any form, which dialect 3 normalizes."""
    if isinstance(direction, VectorField):
        direction = at_position(direction.heading_at)
    finish = normalized if scope.state.dialect == 3 else lambda heading: heading
    if isinstance(direction, LazyValue):
        delayed = direction
        heading: Value = LazyValue(delayed.needs, lambda self: finish(delayed.compute(self)))
    else:
        rotation = classes.as_orientation(direction) if scope.state.dialect == 3 else classes.as_heading(direction)
        hint = "a point is faced by `facing toward`" if as_vector(direction) is not None else ""
        heading = finish(classes.needed("facing", "a heading", direction, rotation, hint))
    return ResolvedSpecifier("facing", node, {"heading": Given(REQUIRED, heading)})


def facing_toward(scope: Scope, node: ast.AST, target: Value) -> ResolvedSpecifier:
    vector = classes.vector_of(target, "facing toward")
    return facing(scope, node, at_position(lambda position: angle_between(position, vector)))


def facing_away(scope: Scope, node: ast.AST, target: Value) -> ResolvedSpecifier:
    vector = classes.vector_of(target, "facing away from")
    return facing(scope, node, at_position(lambda position: angle_between(vector, position)))


def apparently_facing(scope: Scope, node: ast.AST, turn: Value, viewpoint: Value = None) -> ResolvedSpecifier:
    """Set the heading to `turn` relative to the line of sight; dialect 3 sets the yaw, relative to the parent."""
    start = classes.vector_of(or_ego(scope, viewpoint), "apparently facing ... from")
    heading = at_position(lambda position: angle_between(start, position) + turn)
    gives = {"yaw" if scope.state.dialect == 3 else "heading": Given(REQUIRED, heading)}
    return ResolvedSpecifier("apparently facing", node, gives)


SPECIFIERS: dict[str, Callable[..., ResolvedSpecifier]] = {
    "at": at,
    "in": inside,
    "on": inside,
    "contained in": contained_in,
    **dict.fromkeys(DIRECTIONS, beside),
    "offset by": offset_by,
    "offset along": offset_along,
    "beyond": beyond,
    "visible": in_or_out_of_sight,
    "not visible": in_or_out_of_sight,
    "following": following,
    "facing": facing,
    "facing toward": facing_toward,
    "facing away from": facing_away,
    "facing directly toward": facing_toward,
    "facing directly away from": facing_away,
    "apparently facing": apparently_facing,
}
