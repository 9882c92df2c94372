"""Warnings about `with` specifiers that set a property nobody reads.

Scenic lets an object have any property, so a slip such as `with bahavior B()` is silently without effect.
Read next: `check`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from scenic_lite import nodes
from scenic_lite.parser_cursor import nearest

BUILT_IN = frozenset(
    {
        *("position", "heading", "yaw", "width", "length", "speed", "velocity", "angularSpeed", "behavior"),
        *("viewAngle", "visibleDistance", "cameraOffset", "allowCollisions", "requireVisible", "regionContainedIn"),
        *("mutator", "mutationScale", "positionStdDev", "headingStdDev"),
    }
)


def doubtful_properties(tree: ast.Module) -> Iterator[tuple[nodes.Specifier, str, str]]:
    """Each doubtful `with` specifier, with a message and a hint."""
    own = {node.name for node in ast.walk(tree) if isinstance(node, nodes.PropertyDefault)}
    for node in ast.walk(tree):
        if not isinstance(node, nodes.Specifier) or node.name != "with":
            continue
        place, value = node.arguments
        name = place.value if isinstance(place, ast.Constant) else ""
        if not isinstance(name, str) or name in own | BUILT_IN:
            continue
        if isinstance(value, ast.Tuple) and not value.elts and name[:1].isupper():
            message = f'this sets a property called "{name}" to an empty tuple'
            yield node, message, f'write "with behavior {name}()"'
        elif hint := nearest(name, BUILT_IN | own):
            yield node, f'no class has the property "{name}"', hint
