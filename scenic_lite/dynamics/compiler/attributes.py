"""Attributes that a program sets while a match runs: of its objects, and of `simulation()`.

They are seen by all behaviors of the match, so their registers belong to none of them. Read next:
`dynamics.compiler.behaviors`.
"""

from __future__ import annotations

import ast

from scenic_lite.core.environment import near
from scenic_lite.core.types import Instance, RandomChoice, describe_kind
from scenic_lite.dynamics.compiler.compilation import Compilation, CompiledScope
from scenic_lite.dynamics.compiler.emit import register_of
from scenic_lite.dynamics.compiler.registers import Slot, pairs
from scenic_lite.dynamics.machine.bytecode import REWARD
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import checked
from scenic_lite.values.graph import Value, kind_of

# "object" and its label, "simulation" and "", "global" and its module's number; then the attribute or variable
Key = tuple[str, str | int, str]


def set_attribute(c: Compilation, scope: CompiledScope, target: ast.Attribute, owner: Value, value: Value) -> None:
    """`owner.name = value`."""
    name = target.attr
    if owner is c.simulation and name == "scenic_reward":
        if kind_of(value) not in ("number", "truth"):
            raise ScenicError("type", f"a reward is a number, not {describe_kind(value)}")
        register_of(c.code, value, REWARD)
    elif owner is c.simulation:
        own = {key[2] for key in c.shapes if key[0] == "simulation"}  # assigned in the program, as an earlier walk saw
        known = [each for each in c.simulation.names if each not in own]
        if hint := near(name, known) if name not in known else "":
            c.doubts.append(scope.error("warning", f"simulation() has no attribute '{name}' until now", target, hint))
        keep(c, ("simulation", "", name), value)
    elif isinstance(owner, Instance) and owner.label:
        refuse_live(c, owner, name)
        checked_value = checked(name, value, c.program.dialect) if name in owner.properties else value
        keep(c, ("object", owner.label, name), checked_value)
    elif isinstance(owner, RandomChoice):
        raise ScenicError("unsupported", "attributes are set of one object, not of whichever a match finds")
    else:
        raise ScenicError("type", f"the attributes of {describe_kind(owner)} cannot be assigned")


def refuse_live(c: Compilation, owner: Instance, name: str) -> None:
    """What the world says of an object is the world's."""
    if name in ("x", "y") or name in c.live_names:
        hint = "players move by what they do: take an action"
        raise ScenicError("type", f"the {name} of {owner.title()} belongs to the world", hint=hint)


def keep(c: Compilation, key: Key, value: Value) -> None:
    """Assign an attribute that lasts as long as the match."""
    slot = shared(c, key)
    slot.store(value)
    table_of(c, key)[key[2]] = slot.value


def table_of(c: Compilation, key: Key) -> dict[str, Value]:
    """Where an attribute is looked up."""
    kind, label, name = key
    if kind == "global":
        assert isinstance(label, int)
        return c.modules[label]
    if kind == "simulation":
        return c.simulation.names
    owner = next(each for each in c.program.instances if each.label == label)
    return owner.properties if name in owner.properties else owner.attributes


def shared(c: Compilation, key: Key) -> Slot:
    """The slot of an attribute; at the start of a match it holds what the program gave it."""
    if key not in c.shared:
        if key[0] == "global" and key[2] in table_of(c, key):
            assert isinstance(key[1], int)
            c.before.setdefault(key[1], {})[key[2]] = table_of(c, key)[key[2]]
        if key not in c.shapes:  # what was read of it before was taken for fixed
            c.code.widened.add(key)
        slot = c.shared[key] = Slot(c.code, c.shapes, key, shared=True)
        table, name = table_of(c, key), key[2]
        if name in table:
            slot.widen(table[name])
            assert slot.shape is not None
            for register, first in pairs(slot.shape, iter(slot.registers), table[name]):
                c.code.begin_with(register, first)
    return c.shared[key]


def show_shared(c: Compilation) -> None:
    """Let the attributes that a program is known to set be read from their registers."""
    for key in [key for key in c.shapes if key[:1] in (("object",), ("simulation",), ("global",))]:
        slot = shared(c, key)
        table_of(c, key)[key[2]] = slot.value


# ------------------------------------------------------------ what objects did last


def remember(c: Compilation, actions: tuple[Value, ...]) -> None:
    """Note the actions of the present object, for whoever asks for its `lastActions`."""
    if c.remembering:
        assert c.agent is not None
        keep(c, ("object", c.agent.label, LATELY[c.program.dialect]), actions)


def forget(c: Compilation, agents: list[Instance]) -> None:
    """At the start of a step, in dialect 3: nobody has done anything yet."""
    for each in agents:
        keep(c, ("object", each.label, "lastActions"), ())


def reveal(c: Compilation, agents: list[Instance]) -> None:
    """At the end of a step, in dialect 2: only now others see what was done."""
    for each in agents:
        lately = ("object", each.label, LATELY[2])
        keep(c, ("object", each.label, "lastActions"), shared(c, lately).value or ())
        keep(c, lately, ())


LATELY = {2: "(actions of this step)", 3: "lastActions"}
