"""The `raw` observation: a match as Google Research Football's own dict describes it, for N matches at once.

x and y in its units (x/54.4 m; y/83.6 m, pointing down), z in metres, directions per step. The left team is ours.
Read next: `vector_env`.
"""

from __future__ import annotations

import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, Space

from envs.football.constants import METRES_PER_X, METRES_PER_Y, STEP

UNIT_X, UNIT_Y = 100 * METRES_PER_X, -100 * METRES_PER_Y  # m per unit of the original
FAR = 1e6


def raw_space(num_left: int, num_right: int) -> Dict:
    """Give the space of one match's observation with so many players in the left and the right team."""
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
        "score": Box(0, 2**31, (2,), whole),
        "steps_left": Box(0, 2**31, (1,), whole),
        "game_mode": Discrete(7),
    }
    for team, count in (("left_team", num_left), ("right_team", num_right)):
        spaces[team] = Box(-FAR, FAR, (count, 2), real)
        spaces[team + "_direction"] = Box(-FAR, FAR, (count, 2), real)
        spaces[team + "_tired_factor"] = Box(0, 1, (count,), real)
        spaces[team + "_yellow_card"] = MultiBinary(count)
        spaces[team + "_active"] = MultiBinary(count)
        spaces[team + "_roles"] = Box(0, 9, (count,), whole)
    return Dict(spaces)


def raw_observation(matches: np.ndarray, num_left: int, num_players: int) -> dict[str, np.ndarray]:
    """Describe MATCH `[N]`: a dict of arrays, each with N as its first axis.

    Nobody is -1. Cards are not given yet, so nobody is yellow and everyone is active; the ball's rotation is not
    simulated as angles and is 0.
    """
    ball, players = matches["ball"], matches["players"][:, :num_players]
    count = len(matches)
    observation = {
        "ball": np.stack([ball["x"] / UNIT_X, ball["y"] / UNIT_Y, ball["z"]], axis=-1),
        "ball_direction": STEP * np.stack([ball["vx"] / UNIT_X, ball["vy"] / UNIT_Y, ball["vz"]], axis=-1),
        "ball_rotation": np.zeros((count, 3)),
        "ball_owned_team": _of(players, "team", matches["owner"]),
        "ball_owned_player": _of(players, "shirt", matches["owner"]),
        "active": _of(players, "shirt", matches["agents"][:, 0]),
        "designated": _of(players, "shirt", matches["agents"][:, 0]),
        "sticky_actions": _sticky(players, matches["agents"][:, 0]),
        "score": matches["score"].copy(),
        "steps_left": (matches["game_duration"] - matches["step"])[:, None],
        "game_mode": matches["game_mode"].copy(),
    }
    for name, team in (("left_team", players[:, :num_left]), ("right_team", players[:, num_left:])):
        observation[name] = np.stack([team["x"] / UNIT_X, team["y"] / UNIT_Y], axis=-1)
        observation[name + "_direction"] = STEP * np.stack([team["vx"] / UNIT_X, team["vy"] / UNIT_Y], axis=-1)
        observation[name + "_tired_factor"] = team["tired"].copy()
        observation[name + "_yellow_card"] = np.zeros(team.shape, np.int8)
        observation[name + "_active"] = np.ones(team.shape, np.int8)
        observation[name + "_roles"] = team["role"].copy()
    return observation


def _of(players: np.ndarray, field: str, index: np.ndarray) -> np.ndarray:
    """A field `[N]` of the player `index` `[N]`, -1 where that is nobody."""
    return np.where(index < 0, -1, players[field][np.arange(len(players)), index])


def _sticky(players: np.ndarray, controlled: np.ndarray) -> np.ndarray:
    """The ten sticky actions `[N, 10]` of the controlled player: eight directions, sprint, dribble."""
    rows = np.arange(len(players))
    sticky = np.zeros((len(players), 10), np.int8)
    direction = players["direction"][rows, controlled]
    moving = (direction > 0) & (controlled >= 0)
    sticky[rows[moving], direction[moving] - 1] = 1
    sticky[:, 8] = players["sprint"][rows, controlled] & (controlled >= 0)
    sticky[:, 9] = players["dribble"][rows, controlled] & (controlled >= 0)
    return sticky
