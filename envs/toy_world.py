"""The smallest world: every object drifts up the y axis by the same distance in each step, and actions change nothing.

Scenic's authors test behaviors in this simulator, and our tests compare our behaviors with theirs in it. An action is
any value. Tests use it for programs that need no particular simulator. Read next: `scenic_lite.core.world`.
"""

from __future__ import annotations

from typing import Any

from scenic_lite.core.types import Instance, Namespace
from scenic_lite.core.world import World
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import Value

FIELDS = ("x", "y", "heading")
FACTS = ("time",)


def toy_world(timestep: float = 1.0) -> World:
    """Return the world of the toy simulator; `timestep` is the duration of a step in seconds."""

    def simulation(objects: list[Instance], facts: dict[str, Value]) -> Namespace:
        names = {"currentTime": facts["time"], "timestep": timestep, "objects": objects}
        names["agents"] = [instance for instance in objects if instance.properties["behavior"] is not None]
        return Namespace("simulation()", names)

    return World("toy", FIELDS, FACTS, timestep, properties, simulation, lambda action, _: action)


def properties(instance: Instance, fields: dict[str, Value]) -> dict[str, Value]:
    """Return the properties of an object; its speed is 0. Its x is the value in the program, since x never changes."""
    x = instance.properties["position"].x
    at = Vector(x if isinstance(x, int) else fields["x"], fields["y"])
    still: dict[str, Any] = {"velocity": Vector(0, 0), "speed": 0.0, "angularSpeed": 0.0}
    return {"position": at, "heading": fields["heading"]} | still
