"""Assign to names, elements, slices and attributes, and delete them.

Read next: `evaluation.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from scenic_lite.core.exceptions import named_fault
from scenic_lite.core.scope import Frame
from scenic_lite.core.types import Choice, Instance, Namespace, ScenicClass, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.attributes import attribute
from scenic_lite.evaluation.expressions import combined, item_of
from scenic_lite.language.classes import checked, is_object
from scenic_lite.scene.scenes import randoms_in
from scenic_lite.values.graph import Random, Value
from scenic_lite.values.regions import Region


def assign(frame: Frame, node: ast.Assign) -> None:
    value = frame.value(node.value)
    for target in node.targets:
        bind_target(frame, target, value)


def annotated(frame: Frame, node: ast.AnnAssign) -> None:
    if node.value is not None:
        bind_target(frame, node.target, frame.value(node.value))


def augmented(frame: Frame, node: ast.AugAssign) -> None:
    """`target += value`; the container and the index of the target are evaluated once."""
    target = node.target
    if isinstance(target, ast.Name):
        old = frame.session.ego if target.id == "ego" else frame.lookup(target.id)
        bind_target(frame, target, changed(frame, node, old))
    elif isinstance(target, ast.Subscript):
        container, index = frame.value(target.value), frame.value(target.slice)
        new = changed(frame, node, item_of(frame, container, index))
        set_item(frame, target, container, index, new)
    else:
        assert isinstance(target, ast.Attribute)
        owner = frame.value(target.value)
        set_attribute(frame, owner, target.attr, changed(frame, node, attribute(frame, owner, target.attr)))


def changed(frame: Frame, node: ast.AugAssign, old: Value) -> Value:
    """The new value; a list or set that is added to stays the same one."""
    more = frame.value(node.value)
    new = combined(frame, node.op, list_of(frame, node.op, old), list_of(frame, node.op, more, like=old))
    if isinstance(old, list) and isinstance(new, list):
        old[:] = new
        return old
    if isinstance(old, set) and isinstance(new, set):
        if new is not old:
            old.clear()
            old.update(new)
        return old
    return new


def list_of(frame: Frame, sign: ast.operator, value: Value, like: Value = None) -> Value:
    """What a list is extended by may be any collection."""
    if isinstance(sign, ast.Add) and isinstance(like, list) and not isinstance(value, list):
        return frame.elements(value, sign)
    return value


def bind_target(frame: Frame, target: ast.expr, value: Value) -> None:
    """Assign to a name, several names, an element, a slice or an attribute."""
    if isinstance(target, ast.Name):
        if target.id in TRACKED:
            TRACKED[target.id](frame, target, value)
        frame.assign(target.id, value)
    elif isinstance(target, ast.Tuple | ast.List):
        unpack(frame, target, value)
    elif isinstance(target, ast.Subscript):
        set_item(frame, target, frame.value(target.value), frame.value(target.slice), value)
    elif isinstance(target, ast.Attribute):
        owner = frame.value(target.value)
        try:
            set_attribute(frame, owner, target.attr, value)
        except ScenicError as error:
            raise frame.placed(error, target) from None
    else:
        raise frame.error("syntax", "this cannot be assigned to", target)


def set_item(frame: Frame, target: ast.Subscript, container: Value, index: Value, value: Value) -> None:
    """`container[index] = value`."""
    if not isinstance(container, list | dict):
        raise frame.error("type", f"elements of {describe_kind(container)} cannot be assigned here", target)
    if isinstance(container, list):
        frame.refuse_random(index, target, "the index of a list must not be random")
    frame.session.budget.whole(index)
    if isinstance(index, slice) and isinstance(container, list):
        container[index] = frame.elements(value, target)
        frame.session.budget.container(len(container))
    else:
        container[index] = value
        frame.session.budget.spend(1)


def set_attribute(frame: Frame, owner: Value, name: str, value: Value) -> None:
    """`owner.name = value` of an object or a class of the program; a property keeps its type."""
    if isinstance(owner, Instance):
        if name in ("x", "y") and name not in owner.properties:  # would hide the coordinate and move nothing
            hint = f"write {owner.title()}.position = x @ y"
            raise ScenicError("type", f"the {name} of an object belongs to its position", hint=hint)
        if name in owner.properties:
            owner.properties[name] = checked(name, value, frame.session.dialect)
        else:
            owner.attributes[name] = value
    elif isinstance(owner, ScenicClass) and owner.base is not None:
        owner.members[name] = value
    elif isinstance(owner, Namespace) and owner.open:
        owner.names[name] = value
    elif isinstance(owner, Choice):
        raise ScenicError("type", "the attributes of a random object cannot be assigned")
    else:
        error = ScenicError("type", f"the attributes of {describe_kind(owner)} cannot be assigned")
        raise named_fault("AttributeError", error)


def unpack(frame: Frame, target: ast.expr, value: Value) -> None:
    """`a, b = value`, or a plain name."""
    if not isinstance(target, ast.Tuple | ast.List):
        bind_target(frame, target, value)
        return
    items = frame.elements(value, target)
    stars = [i for i, each in enumerate(target.elts) if isinstance(each, ast.Starred)]
    if stars:
        after = len(target.elts) - stars[0] - 1
        if len(items) < len(target.elts) - 1:
            raise frame.error("value", f"{len(items)} values for at least {len(target.elts) - 1} names", target)
        middle = items[stars[0] : len(items) - after]
        items = [*items[: stars[0]], middle, *items[len(items) - after :]]
    if len(items) != len(target.elts):
        raise frame.error("value", f"{len(items)} values for {len(target.elts)} names", target)
    for each, item in zip(target.elts, items, strict=True):
        bind_target(frame, each.value if isinstance(each, ast.Starred) else each, item)


# ------------------------------------------------------------ names that the language tracks


def set_ego(frame: Frame, node: ast.AST, value: Value) -> None:
    if not is_object(value):
        raise frame.error("type", f"ego must be an object, not {describe_kind(value)}", node)
    frame.session.ego = value


def set_workspace(frame: Frame, node: ast.AST, value: Value) -> None:
    hint = "write workspace = Workspace(region)"
    if not isinstance(value, Region):
        raise frame.error("type", f"the workspace must be a region, not {describe_kind(value)}", node, hint)
    drawn = next(randoms_in(value), None)
    if isinstance(drawn, Random):
        raise frame.error("value", "the workspace must be fixed", node, notes=frame.drawn_notes(drawn))
    frame.session.workspace = value


TRACKED: dict[str, Callable[[Frame, ast.AST, Value], None]] = {"ego": set_ego, "workspace": set_workspace}

# ------------------------------------------------------------ del


def delete(frame: Frame, node: ast.Delete) -> None:
    for target in node.targets:
        delete_target(frame, target)


def delete_target(frame: Frame, target: ast.expr) -> None:
    if isinstance(target, ast.Name):
        scope = frame.scope_of(target.id)
        if target.id in TRACKED:
            raise frame.error("unsupported", f"'{target.id}' cannot be deleted", target)
        if target.id not in scope:
            raise frame.error("name", f"name '{target.id}' is not defined", target)
        del scope[target.id]
    elif isinstance(target, ast.Tuple | ast.List):
        for each in target.elts:
            delete_target(frame, each)
    elif isinstance(target, ast.Subscript):
        container, index = frame.value(target.value), frame.value(target.slice)
        if not isinstance(container, list | dict):
            raise frame.error("type", f"elements of {describe_kind(container)} cannot be deleted", target)
        frame.refuse_random(index, target, "the index of what is deleted must not be random")
        frame.session.budget.whole(index)
        del container[index]
    else:
        assert isinstance(target, ast.Attribute)
        owner = frame.value(target.value)
        if not isinstance(owner, Instance) or target.attr not in owner.attributes:
            error = frame.error("name", f"'{target.attr}' of {describe_kind(owner)} cannot be deleted", target)
            raise named_fault("AttributeError", error)
        del owner.attributes[target.attr]


ASSIGNMENTS: dict[type, Callable[[Frame, Any], None]] = {
    ast.Assign: assign,
    ast.AnnAssign: annotated,
    ast.AugAssign: augmented,
    ast.Delete: delete,
}
