"""From a match to the tables that behaviors read: a row of `FIELDS` per object, then `FACTS`.

Meters become Scenic units; directions of the right team are reported as its players see the pitch, from the other end.
Read next: `scenic.scripted_step`, which runs a program's behaviors in a match.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from regista.envs.football.constants import METRES_PER_X, METRES_PER_Y, NOBODY, RUNNING
from regista.envs.football.control.agents import in_team_frame
from regista.envs.football.scenic.world_fields import FIELDS
from regista.kernels.jit import kernel

THE_BALL = -1  # instead of the index of a player
NUM_FIELDS, HEADING = len(FIELDS), FIELDS.index("heading")
UNREAD, BUT_HEADING, WHOLE = range(3)  # the fields of an object that a program reads


class Cast(NamedTuple):
    """The players of the O objects of a program, and the fields that it reads; only these fields are written."""

    players: np.ndarray  # [O] int64, the player of each object, or THE_BALL
    read: np.ndarray  # [O] int64, UNREAD, BUT_HEADING or WHOLE


@kernel
def write_world(match, object_to_player, registers, base, read=None):
    """Write the tables into registers `[R]` from `base` on: fields `[O, F]`, then facts `[G]`.

    `object_to_player` and `read` are fields of a `Cast`; with `read` None, all fields are written.
    """
    at = base
    for o in range(len(object_to_player)):
        what, i = WHOLE if read is None else read[o], object_to_player[o]
        if what != UNREAD and i == THE_BALL:
            _write_ball(match, registers, at, what == WHOLE)
        elif what != UNREAD:
            _write_player(match, i, registers, at, what == WHOLE)
        at += NUM_FIELDS
    registers[at] = match.step
    registers[at + 1] = match.game_duration - match.step
    registers[at + 2] = match.score[0]
    registers[at + 3] = match.score[1]
    registers[at + 4] = match.game_mode
    registers[at + 5] = 1.0 if match.ended != RUNNING else 0.0


@kernel
def _write_player(match, i, registers, at, with_heading):
    player = match.players[i]
    _write_motion(player, registers, at)
    if with_heading:
        registers[at + HEADING] = heading(player.facing_x / METRES_PER_X, player.facing_y / METRES_PER_Y)
    registers[at + 6] = 1.0 if match.reported_owner == i else 0.0
    registers[at + 7] = 1.0 if player.agent != NOBODY else 0.0
    registers[at + 8] = player.tiredness
    registers[at + 9] = in_team_frame(player.team, player.direction)
    registers[at + 10] = 1.0 if player.sprint else 0.0
    registers[at + 11] = 1.0 if player.dribble else 0.0
    registers[at + 12] = NOBODY
    registers[at + 13] = NOBODY


@kernel
def _write_ball(match, registers, at, with_heading):
    ball = match.ball
    _write_motion(ball, registers, at)
    if with_heading:
        registers[at + HEADING] = heading(ball.vx / METRES_PER_X, ball.vy / METRES_PER_Y)
    registers[at + 6 : at + 12] = 0.0
    registers[at + 12] = NOBODY
    registers[at + 13] = NOBODY
    if match.reported_owner != NOBODY:
        registers[at + 12] = match.players[match.reported_owner].team
        registers[at + 13] = match.players[match.reported_owner].shirt


@kernel
def _write_motion(body, registers, at):
    """Write position, velocity and speed of a player or the ball."""
    vx, vy = body.vx / METRES_PER_X, body.vy / METRES_PER_Y
    registers[at] = body.x / METRES_PER_X
    registers[at + 1] = body.y / METRES_PER_Y
    registers[at + 3] = vx
    registers[at + 4] = vy
    registers[at + 5] = math.sqrt(vx * vx + vy * vy)


@kernel
def heading(x, y):
    """Return the heading of (x, y) in [0, 2π); 0 for a zero vector."""
    if x == 0.0 and y == 0.0:
        return 0.0
    angle = math.atan2(-x, y)
    return angle if angle >= 0.0 else angle + 2.0 * math.pi
