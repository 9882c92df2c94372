"""Assign to names, elements, slices and attributes, and delete them.

Read next: `evaluation.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Instance, Namespace, RandomChoice, ScenicClass, describe_kind, randoms_in
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.attributes import attribute
from scenic_lite.evaluation.expressions import combine, item_of
from scenic_lite.language.classes import checked, is_object
from scenic_lite.values.graph import RandomExpr, Value
from scenic_lite.values.regions import Region


def assign(scope: Scope, node: ast.Assign) -> None:
    value = scope.value(node.value)
    for target in node.targets:
        bind_target(scope, target, value)


def annotated(scope: Scope, node: ast.AnnAssign) -> None:
    if node.value is not None:
        bind_target(scope, node.target, scope.value(node.value))


def augmented(scope: Scope, node: ast.AugAssign) -> None:
    """`target += value`; the container and the index of the target are evaluated once."""
    target = node.target
    if isinstance(target, ast.Name):
        old = scope.state.ego if target.id == "ego" else scope.lookup(target.id)
        bind_target(scope, target, changed(scope, node, old))
    elif isinstance(target, ast.Subscript):
        container, index = scope.value(target.value), scope.value(target.slice)
        new = changed(scope, node, item_of(scope, container, index))
        set_item(scope, target, container, index, new)
    else:
        assert isinstance(target, ast.Attribute)
        owner = scope.value(target.value)
        set_attribute(scope, owner, target.attr, changed(scope, node, attribute(scope, owner, target.attr)))


def changed(scope: Scope, node: ast.AugAssign, old: Value) -> Value:
    """Return the new value; a list that is added to stays the same one."""
    more = scope.value(node.value)
    new = combine(scope, node.op, list_of(scope, node.op, old), list_of(scope, node.op, more, like=old))
    if isinstance(old, list) and isinstance(new, list):
        old[:] = new
        return old
    return new


def list_of(scope: Scope, sign: ast.operator, value: Value, like: Value = None) -> Value:
    """Return the elements of what a list is extended by, which may be any collection."""
    if isinstance(sign, ast.Add) and isinstance(like, list) and not isinstance(value, list):
        return scope.elements(value, sign)
    return value


def bind_target(scope: Scope, target: ast.expr, value: Value) -> None:
    """Assign to a name, several names, an element, a slice or an attribute."""
    if isinstance(target, ast.Name):
        if target.id in TRACKED:
            TRACKED[target.id](scope, target, value)
        scope.assign(target.id, value)
    elif isinstance(target, ast.Tuple | ast.List):
        unpack(scope, target, value)
    elif isinstance(target, ast.Subscript):
        set_item(scope, target, scope.value(target.value), scope.value(target.slice), value)
    elif isinstance(target, ast.Attribute):
        owner = scope.value(target.value)
        try:
            set_attribute(scope, owner, target.attr, value)
        except ScenicError as error:
            raise scope.placed(error, target) from None
    else:
        raise scope.error("syntax", "this cannot be assigned to", target)


def set_item(scope: Scope, target: ast.Subscript, container: Value, index: Value, value: Value) -> None:
    """`container[index] = value`."""
    if not isinstance(container, list | dict):
        raise scope.error("type", f"elements of {describe_kind(container)} cannot be assigned here", target)
    if isinstance(container, list):
        scope.refuse_random(index, target, "the index of a list must not be random")
    scope.mode.budget.whole(index)
    if isinstance(index, slice) and isinstance(container, list):
        container[index] = scope.elements(value, target)
        scope.mode.budget.container(len(container))
    else:
        container[index] = value
        scope.mode.budget.spend(1)


def set_attribute(scope: Scope, owner: Value, name: str, value: Value) -> None:
    """`owner.name = value` of an object or a class of the program; a property keeps its type."""
    if isinstance(owner, Instance):
        if name in ("x", "y") and name not in owner.properties:  # would hide the coordinate and move nothing
            hint = f"write {owner.title()}.position = x @ y"
            raise ScenicError("type", f"the {name} of an object belongs to its position", hint=hint)
        if name in owner.properties:
            owner.properties[name] = checked(name, value, scope.state.dialect)
        else:
            owner.attributes[name] = value
    elif isinstance(owner, ScenicClass) and owner.base is not None:
        owner.members[name] = value
    elif isinstance(owner, Namespace) and owner.open:
        owner.names[name] = value
    elif isinstance(owner, RandomChoice):
        raise ScenicError("type", "the attributes of a random object cannot be assigned")
    else:
        raise ScenicError("type", f"the attributes of {describe_kind(owner)} cannot be assigned")


def unpack(scope: Scope, target: ast.expr, value: Value) -> None:
    """`a, b = value`, or a plain name."""
    if not isinstance(target, ast.Tuple | ast.List):
        bind_target(scope, target, value)
        return
    items = scope.elements(value, target)
    stars = [i for i, part in enumerate(target.elts) if isinstance(part, ast.Starred)]
    if stars:
        after = len(target.elts) - stars[0] - 1
        if len(items) < len(target.elts) - 1:
            raise scope.error("value", f"{len(items)} values for at least {len(target.elts) - 1} names", target)
        middle = items[stars[0] : len(items) - after]
        items = [*items[: stars[0]], middle, *items[len(items) - after :]]
    if len(items) != len(target.elts):
        raise scope.error("value", f"{len(items)} values for {len(target.elts)} names", target)
    for part, item in zip(target.elts, items, strict=True):
        bind_target(scope, part.value if isinstance(part, ast.Starred) else part, item)


# ------------------------------------------------------------ names that the language tracks


def set_ego(scope: Scope, node: ast.AST, value: Value) -> None:
    if not is_object(value):
        raise scope.error("type", f"ego must be an object, not {describe_kind(value)}", node)
    scope.state.ego = value


def set_workspace(scope: Scope, node: ast.AST, value: Value) -> None:
    hint = "write workspace = Workspace(region)"
    if not isinstance(value, Region):
        raise scope.error("type", f"the workspace must be a region, not {describe_kind(value)}", node, hint)
    drawn = next(randoms_in(value), None)
    if isinstance(drawn, RandomExpr):
        raise scope.error("value", "the workspace must be fixed", node, notes=scope.drawn_notes(drawn))
    scope.state.workspace = value


TRACKED: dict[str, Callable[[Scope, ast.AST, Value], None]] = {"ego": set_ego, "workspace": set_workspace}

# ------------------------------------------------------------ del


def delete(scope: Scope, node: ast.Delete) -> None:
    for target in node.targets:
        delete_target(scope, target)


def delete_target(scope: Scope, target: ast.expr) -> None:
    if isinstance(target, ast.Name):
        names = scope.names_of(target.id)
        if target.id in TRACKED:
            raise scope.error("unsupported", f"'{target.id}' cannot be deleted", target)
        if target.id not in names:
            raise scope.error("name", f"name '{target.id}' is not defined", target)
        del names[target.id]
    elif isinstance(target, ast.Tuple | ast.List):
        for part in target.elts:
            delete_target(scope, part)
    elif isinstance(target, ast.Subscript):
        container, index = scope.value(target.value), scope.value(target.slice)
        if not isinstance(container, list | dict):
            raise scope.error("type", f"elements of {describe_kind(container)} cannot be deleted", target)
        scope.refuse_random(index, target, "the index of what is deleted must not be random")
        scope.mode.budget.whole(index)
        del container[index]
    else:
        assert isinstance(target, ast.Attribute)
        owner = scope.value(target.value)
        if not isinstance(owner, Instance) or target.attr not in owner.attributes:
            raise scope.error("name", f"'{target.attr}' of {describe_kind(owner)} cannot be deleted", target)
        del owner.attributes[target.attr]


ASSIGNMENTS: dict[type, Callable[[Scope, Any], None]] = {
    ast.Assign: assign,
    ast.AnnAssign: annotated,
    ast.AugAssign: augmented,
    ast.Delete: delete,
}
