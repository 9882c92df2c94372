"""The football world as programs see it: live properties of players and ball, the state of the game, the actions.

Units are Scenic's: x from -100 to 100, y from -42 to 42, headings in radians counterclockwise from +y. Importing this
module compiles nothing. Read next: `scenic.world_table`, which fills the tables from a match.
"""

from __future__ import annotations

from regista.envs.football.constants import BUILTIN_AI, NUM_COMMANDS, STEP
from regista.envs.football.scenic.world_fields import FACTS, FIELDS
from scenic_lite.core.types import Instance, Namespace, describe_kind
from scenic_lite.core.world import World
from scenic_lite.errors import ScenicError
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Value, apply
from scenic_lite.values.operations import EQUAL, INTEGER, NOT_EQUAL


def properties(instance: Instance, fields: dict[str, Value]) -> dict[str, Value]:
    """Return the live properties of one object."""
    live: dict[str, Value] = {
        "position": Vector(fields["x"], fields["y"]),
        "velocity": Vector(fields["vx"], fields["vy"]),
        "speed": fields["speed"],
        "heading": fields["heading"],
        "direction": fields["heading"],
    }
    if is_ball(instance):
        return live | {name: apply(INTEGER, fields[name]) for name in ("owned_team", "owned_player_idx")}
    directions = [apply(EQUAL, fields["pressed"], float(each), kind="truth") for each in range(1, 9)]
    sprint, dribble, owns, controlled = (
        apply(NOT_EQUAL, fields[name], 0.0, kind="truth")
        for name in ("sprint", "dribble", "owns_ball", "is_controlled")
    )
    return live | {
        "tired_factor": fields["tired_factor"],
        "owns_ball": owns,
        "is_controlled": controlled,
        "sticky_actions": [*directions, sprint, dribble],
    }


def simulation(objects: list[Instance], facts: dict[str, Value]) -> Namespace:
    """Return the value of `simulation()`: the state of the game, with the names that Scenic4RL's programs use."""
    players = [instance for instance in objects if not is_ball(instance)]
    left = [instance for instance in players if instance.properties["team"] == "left"]
    right = [instance for instance in players if instance.properties["team"] == "right"]
    game = {
        "frame": facts["time"],
        "steps_left": facts["steps_left"],
        "score": [facts["score_left"], facts["score_right"]],
        "score_left": facts["score_left"],
        "score_right": facts["score_right"],
        "game_mode": facts["game_mode"],
    }
    seen = game | {"players": players, "left_players": left, "right_players": right}
    seen |= {"my_players": left, "op_players": right, "game_state": Namespace("game_state", game)}
    seen["ball"] = next((instance for instance in objects if is_ball(instance)), None)
    return Namespace(
        "simulation()",
        {
            "currentTime": facts["time"],
            "timestep": STEP,
            "objects": objects,
            "game_ds": Namespace("game_ds", seen),
            "scenic_reward": 0.0,
            "done": apply(NOT_EQUAL, facts["done"], 0.0, kind="truth"),
        },
    )


def command(value: Value, instance: Instance) -> Value:
    """Return the number of an action, 0 to 19. Raises ScenicError for other values, and for an action of the ball."""
    if is_ball(instance):
        raise ScenicError("type", f"{instance.title()} is a ball; only players take actions")
    if isinstance(value, RandomExpr) and value.kind == "number":
        return value
    if not isinstance(value, int | float) or isinstance(value, bool):
        kind = describe_kind(value).replace("a random", "a")
        hint = "to do nothing for a step, write wait" if value is None else "write take Shoot()"
        hint = "write its brackets, as in take Shoot()" if kind == "a function" else hint
        raise ScenicError("type", f"an action of football is a number, not {kind}", hint=hint)
    if not 0 <= value <= BUILTIN_AI or value != int(value):
        raise ScenicError("value", FOOTBALL_WORLD.no_action(f"{value:g}"))
    return value


def is_ball(instance: Instance) -> bool:
    """Return whether an object is the ball."""
    return any(cls.name == "Ball" for cls in instance.cls.lineage())


FOOTBALL_WORLD = World("football", FIELDS, FACTS, STEP, properties, simulation, command, NUM_COMMANDS)
