"""The `simple115` observation: Google Research Football's vector of 115 numbers (version 2), at most 11 players a team.

    0:22    positions x, y of our team     66:88    directions of theirs     94:97    owner: nobody, we, they
    22:44   directions of our team         88:91    ball x, y, z             97:108   our active player
    44:66   positions of theirs            91:94    its direction            108:115  game mode

Units and frame are those of `raw`; missing players are -1. Read next: `observation.raw`.
"""

from __future__ import annotations

import numpy as np

from regista.envs.football.constants import HALF_LENGTH, HALF_WIDTH, LEFT, NOBODY, STEP
from regista.envs.football.observation.units import ALOFT, FLYING, RUNNING, UNIT_X, UNIT_Y
from regista.kernels.jit import kernel

SIZE = 115
TEAM = 11  # maximum number of players of a team
_DIRECTIONS, _THEIRS, _BALL, _OWNER, _ACTIVE, _MODE = 22, 44, 88, 94, 97, 108


def simple115_unit() -> np.ndarray:
    """Return the size of a large change of each entry `[115]`: half a pitch, a sprint, a shot, the crossbar's height,
    or 1.

    Speeds in this format are per step and far below 1. These units scale them as in `features`.
    """
    unit, plane = np.ones(SIZE), np.array([1 / UNIT_X, -1 / UNIT_Y])
    players = unit[:_BALL].reshape(2, 2, TEAM, 2)  # team, place or direction, player, x or y
    players[:, 0], players[:, 1] = plane * (HALF_LENGTH, HALF_WIDTH), plane * RUNNING * STEP
    unit[_BALL : _BALL + 3] = *plane * (HALF_LENGTH, HALF_WIDTH), ALOFT
    unit[_BALL + 3 : _OWNER] = STEP * FLYING * np.array([*plane, 1.0])
    return unit


def simple115_names() -> tuple[str, ...]:
    """Return the names of the entries `[115]`, in order."""
    teams = [
        f"{team}{i}.{what}{axis}"
        for team in ("our", "their")
        for what in ("", "d")
        for i in range(TEAM)
        for axis in "xy"
    ]
    ball = [f"ball.{what}{axis}" for what in ("", "d") for axis in "xyz"]
    owner = [f"owned.{who}" for who in ("nobody", "ours", "theirs")]
    return (*teams, *ball, *owner, *(f"active.{i}" for i in range(TEAM)), *(f"mode.{i}" for i in range(7)))


@kernel
def write_simple115(match, agent, row):
    """Write the observation of an agent into `row` `[115]` float32; zeros if it has no player."""
    row[:] = 0.0
    if match.agents[agent] == NOBODY:
        return
    me = match.players[match.agents[agent]]
    row[:_BALL] = -1.0
    side = 1.0 if me.team == LEFT else -1.0  # the right team sees the pitch rotated by 180°
    for i in range(match.num_players):
        player = match.players[i]
        if player.has_left:
            continue  # the same as for a missing player
        at = 2 * player.shirt + (0 if player.team == me.team else _THEIRS)
        row[at] = side * player.x / UNIT_X
        row[at + 1] = side * player.y / UNIT_Y
        row[at + _DIRECTIONS] = side * STEP * player.vx / UNIT_X
        row[at + _DIRECTIONS + 1] = side * STEP * player.vy / UNIT_Y
    _write_ball(match.ball, side, row)
    owner = 0
    if match.reported_owner != NOBODY:
        owner = 1 if match.players[match.reported_owner].team == me.team else 2
    row[_OWNER + owner] = 1.0
    row[_ACTIVE + me.shirt] = 1.0
    row[_MODE + match.game_mode] = 1.0


@kernel
def _write_ball(ball, side, row):
    row[_BALL] = side * ball.x / UNIT_X
    row[_BALL + 1] = side * ball.y / UNIT_Y
    row[_BALL + 2] = ball.z
    row[_BALL + 3] = side * STEP * ball.vx / UNIT_X
    row[_BALL + 4] = side * STEP * ball.vy / UNIT_Y
    row[_BALL + 5] = STEP * ball.vz
