"""The `raw` observation: a match as Google Research Football's dict, for N matches at once.

x and y are in GRF's units (x/54.4 m; y/83.6 m, pointing down), z is in meters, directions are per step. An agent of the
right team sees the pitch rotated by 180°, its own team as `left_team`. `row` gives the dict of one match with GRF's
types.
Read next: `vector_env`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Space

from regista.envs.football.constants import BALL_RADIUS, STEP
from regista.envs.football.observation.units import SPIN_UNIT, UNIT_X, UNIT_Y

FAR = 1e6
MANY = 2**31  # maximum of goals and steps


def raw_space(ours: int, theirs: int) -> Dict:
    """Return the space of one agent's observation, given the numbers of players in its own and in the other team."""
    real, whole = np.float64, np.int64
    spaces: dict[str, Space] = {
        "ball": Box(-FAR, FAR, (3,), real),
        "ball_direction": Box(-FAR, FAR, (3,), real),
        "ball_rotation": Box(-FAR, FAR, (3,), real),
        "ball_owned_team": Discrete(3, start=-1),
        "ball_owned_player": Discrete(12, start=-1),
        "active": Discrete(12, start=-1),
        "designated": Discrete(12, start=-1),
        "sticky_actions": MultiBinary(10),
        "score": MultiDiscrete([MANY, MANY]),
        "steps_left": Discrete(MANY),
        "game_mode": Discrete(7),
    }
    for team, count in (("left_team", ours), ("right_team", theirs)):
        spaces[team] = Box(-FAR, FAR, (count, 2), real)
        spaces[team + "_direction"] = Box(-FAR, FAR, (count, 2), real)
        spaces[team + "_tired_factor"] = Box(0, 1, (count,), real)
        spaces[team + "_yellow_card"] = MultiBinary(count)
        spaces[team + "_active"] = MultiBinary(count)
        spaces[team + "_roles"] = Box(0, 9, (count,), whole)
    return Dict(spaces)


def raw_observation(matches: np.ndarray, agent: int, sizes: tuple[int, int], right: bool) -> dict[str, np.ndarray]:
    """Describe MATCH `[N]` to an agent of the left or the right team: a dict of arrays, each with N as its first axis.

    `sizes` are the numbers of players of both teams. -1 means no player.
    """
    ball, players = matches["ball"], matches["players"][:, : sum(sizes)]
    me, us, side = matches["agents"][:, agent], int(right), -1.0 if right else 1.0
    plane = side * np.array([1 / UNIT_X, 1 / UNIT_Y])
    spin = SPIN_UNIT / BALL_RADIUS * side
    owners = _of(players, "team", matches["reported_owner"])
    alone, chosen = matches["num_agents"][:, us] == 1, matches["designated"][:, us]
    turning = np.stack([-spin * ball["spin_y"], spin * ball["spin_x"], np.zeros(len(ball))], axis=-1)
    chosen = np.where(chosen < 0, np.where(alone, me, matches["chaser"][:, us]), chosen)
    observation: dict[str, np.ndarray] = {
        "ball": _vectors(plane, ball["x"], ball["y"], ball["z"]),
        "ball_direction": STEP * _vectors(plane, ball["vx"], ball["vy"], ball["vz"]),
        "ball_rotation": turning,
        "ball_owned_team": np.where(owners < 0, -1, owners ^ us),
        "ball_owned_player": _of(players, "shirt", matches["reported_owner"]),
        "active": _of(players, "shirt", me),
        "designated": _of(players, "shirt", chosen),
        "sticky_actions": _sticky(players, me, right),
        "score": matches["score"][:, ::-1].copy() if right else matches["score"].copy(),
        "steps_left": matches["game_duration"] - matches["step"],
        "game_mode": matches["game_mode"].copy(),
    }
    teams = players[:, : sizes[0]], players[:, sizes[0] :]
    for name, team in (("left_team", teams[us]), ("right_team", teams[1 - us])):
        observation[name] = _vectors(plane, team["x"], team["y"])
        observation[name + "_direction"] = STEP * _vectors(plane, team["vx"], team["vy"])
        observation[name + "_tired_factor"] = team["tiredness"].copy()
        observation[name + "_yellow_card"] = team["cards"] > 0
        observation[name + "_active"] = ~team["has_left"]
        observation[name + "_roles"] = team["role"].copy()
    return observation


def row(observation: dict[str, np.ndarray], index: int) -> dict[str, Any]:
    """Return one match's dict with GRF's types: integers are `int`, the score is a list of two."""
    observed: dict[str, Any] = {name: values[index] for name, values in observation.items()}
    for name in ("ball_owned_team", "ball_owned_player", "active", "designated", "steps_left", "game_mode"):
        observed[name] = int(observed[name])
    observed["score"] = observed["score"].tolist()
    observed["sticky_actions"] = observed["sticky_actions"].astype(np.uint8)
    return observed


def _vectors(plane: np.ndarray, x: np.ndarray, y: np.ndarray, *z: np.ndarray) -> np.ndarray:
    """Return vectors `[..., 2]` or `[..., 3]` in the units and the frame of the observation."""
    return np.stack([x * plane[0], y * plane[1], *z], axis=-1)


def _of(players: np.ndarray, field: str, index: np.ndarray) -> np.ndarray:
    """Return a field `[N]` of the player `index` `[N]`, -1 for no player."""
    return np.where(index < 0, -1, players[field][np.arange(len(players)), index])


def _sticky(players: np.ndarray, me: np.ndarray, right: bool) -> np.ndarray:
    """Return the ten sticky actions `[N, 10]` of an agent's player `[N]`: eight directions, sprint, dribble."""
    rows = np.arange(len(players))
    sticky = np.zeros((len(players), 10), np.int8)  # the type of Gymnasium's `MultiBinary`
    direction = players["direction"][rows, me]
    pressed = (direction > 0) & (me >= 0)
    sticky[rows[pressed], (direction[pressed] - 1 + 4 * right) % 8] = 1
    sticky[:, 8] = players["sprint"][rows, me] & (me >= 0)
    sticky[:, 9] = players["dribble"][rows, me] & (me >= 0)
    return sticky
