"""Warnings about specifiers that are allowed but surely not meant.

Scenic lets an object have any property, so a slip such as `with bahavior B()` is silently without effect; and a heading
without `deg` is in radians. Read next: `syntax.check`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator

from scenic_lite.syntax import nodes
from scenic_lite.syntax.cursor import nearest

BUILT_IN = frozenset(
    {
        *("position", "heading", "yaw", "width", "length", "speed", "velocity", "angularSpeed", "behavior"),
        *("viewAngle", "visibleDistance", "cameraOffset", "allowCollisions", "requireVisible", "regionContainedIn"),
        *("mutator", "mutationScale", "positionStdDev", "headingStdDev"),
    }
)
ANGLES = frozenset({"facing", "apparently facing", "heading", "yaw", "viewAngle"})
MAX_NAMES = 500  # of properties that are compared with the known ones


def doubts(tree: ast.Module) -> Iterator[tuple[nodes.Specifier, str, str]]:
    """Each doubtful specifier, with a message and a hint."""
    known = BUILT_IN | {node.name for node in ast.walk(tree) if isinstance(node, nodes.PropertyDefault)}
    hints: dict[str, str] = {}
    for node in ast.walk(tree):
        if not isinstance(node, nodes.Specifier):
            continue
        name, value = node.name, node.arguments[0] if node.arguments else None
        if name == "with":
            place, value = node.arguments
            name = str(place.value) if isinstance(place, ast.Constant) else ""
            if isinstance(value, ast.Tuple) and not value.elts and name[:1].isupper():
                message = f'this sets a property called "{name}" to an empty tuple'
                yield node, message, f'write "with behavior {name}()"'
                continue
            if name not in hints:
                hints[name] = "" if name in known or len(hints) > MAX_NAMES else nearest(name, known)
            if hints[name]:
                yield node, f'no class has the property "{name}"', hints[name]
        if name in ANGLES and (turns := _turns(value)):
            yield node, f"angles are in radians, and this one makes {turns:.0f} turns", 'degrees are written "90 deg"'


def _turns(value: ast.expr | None) -> float:
    """How often a literal angle goes round, if that is too often to be meant."""
    if isinstance(value, ast.UnaryOp):
        value = value.operand
    if isinstance(value, ast.Constant) and isinstance(value.value, int | float) and value.value > 4 * math.pi:
        return value.value / (2 * math.pi)
    return 0.0
