"""The smallest world: every object drifts up the y axis by the same distance in each step, and actions change nothing.

It is the simulator in which Scenic's authors test behaviors, and in which ours are compared with theirs. An action is
any value. It stands for whatever no simulator is known for. Read next: `scenic_lite.core.world`.
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
    """Return the world of the toy simulator, with so many seconds to a step."""

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
