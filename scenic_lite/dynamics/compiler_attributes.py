"""Attributes that a program sets while a match runs: of its objects, and of `simulation()`.

They are seen by all behaviors of the match, so their registers belong to none of them. Read next: `compiler_behaviors`.
"""

from __future__ import annotations

import ast

from scenic_lite.dynamics.bytecode import REWARD
from scenic_lite.dynamics.compiler_code import Live
from scenic_lite.dynamics.compiler_emit import register_of
from scenic_lite.dynamics.compiler_frame import Compilation, LiveFrame
from scenic_lite.dynamics.compiler_slots import Slot, pairs
from scenic_lite.errors import ScenicError
from scenic_lite.graph import Value, kind_of
from scenic_lite.values import Choice, Instance, Namespace, describe_kind


def set_attribute(c: Compilation, frame: LiveFrame, target: ast.Attribute, owner: Value, value: Value) -> None:
    """`owner.name = value`."""
    name = target.attr
    if owner is c.simulation and name == "scenic_reward":
        if kind_of(value) not in ("number", "truth"):
            raise ScenicError("type", f"a reward is a number, not {describe_kind(value)}")
        register_of(c.code, value, REWARD)
    elif isinstance(owner, Namespace) and owner.open:
        keep(c, owner.names, ("namespace", owner.name, name), name, value)
    elif isinstance(owner, Instance):
        refuse_live(c, owner, name)
        table = owner.properties if name in owner.properties else owner.attributes
        keep(c, table, ("object", owner.label, name), name, value)
    elif isinstance(owner, Choice):
        raise ScenicError("unsupported", "attributes are set of one object, not of whichever a match finds")
    else:
        raise ScenicError("type", f"the attributes of {describe_kind(owner)} cannot be assigned")


def refuse_live(c: Compilation, owner: Instance, name: str) -> None:
    """What the world says of an object is the world's."""
    value = owner.properties.get(name)
    if name in ("x", "y", "position", "heading") or (isinstance(value, Live) and name in c.live_names):
        hint = "players move by what they do: take an action"
        raise ScenicError("type", f"the {name} of {owner.title()} belongs to the world", hint=hint)


def keep(c: Compilation, table: dict[str, Value], key: tuple, name: str, value: Value) -> None:
    """Assign an attribute that lasts as long as the match."""
    shared(c, table, key, name).store(value)
    table[name] = c.shared[key].value


def shared(c: Compilation, table: dict[str, Value], key: tuple, name: str) -> Slot:
    """The slot of an attribute; at the start of a match it holds what the program gave it."""
    if key not in c.shared:
        slot = Slot(c.code, c.shapes, key, shared=True)
        c.shared[key] = slot
        c.owners[key] = (table, name)
        if name in table:
            slot.widen(table[name])
            assert slot.shape is not None
            for register, first in pairs(slot.shape, iter(slot.registers), table[name]):
                c.code.begin_with(register, first)
    return c.shared[key]


def reward_value() -> Live:
    return Live(REWARD)
