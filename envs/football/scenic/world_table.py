"""From a match to the tables that behaviors read: a row of `FIELDS` per object, then `FACTS`.

Metres become units of programs; the right team's direction keys are told as its players see the pitch, from the other
end. Read next: `scenic.scripted_step`, which plays a program's behaviors in a match.
"""

from __future__ import annotations

import math

from envs.football.constants import METRES_PER_X, METRES_PER_Y, NOBODY, RUNNING
from envs.football.control.agents import seen_by
from envs.football.scenic.world_fields import FIELDS
from scenic_lite.kernels.jit import kernel

THE_BALL = -1  # in place of a player's index
NUM_FIELDS = len(FIELDS)


@kernel
def write_world(match, object_to_player, registers, base):
    """Write the tables into registers `[R]` from `base` on: fields `[O, F]`, then facts `[G]`.

    `object_to_player` [O]: the player that each object of the program is, THE_BALL for the ball.
    """
    at = base
    for i in object_to_player:
        if i == THE_BALL:
            _write_ball(match, registers, at)
        else:
            _write_player(match, i, registers, at)
        at += NUM_FIELDS
    registers[at] = match.step
    registers[at + 1] = match.game_duration - match.step
    registers[at + 2] = match.score[0]
    registers[at + 3] = match.score[1]
    registers[at + 4] = match.game_mode
    registers[at + 5] = 1.0 if match.ended != RUNNING else 0.0


@kernel
def _write_player(match, i, registers, at):
    player = match.players[i]
    _write_motion(player, player.facing_x, player.facing_y, registers, at)
    registers[at + 6] = 1.0 if match.reported_owner == i else 0.0
    registers[at + 7] = 1.0 if player.agent != NOBODY else 0.0
    registers[at + 8] = player.tiredness
    registers[at + 9] = seen_by(player.team, player.direction)
    registers[at + 10] = 1.0 if player.sprint else 0.0
    registers[at + 11] = 1.0 if player.dribble else 0.0
    registers[at + 12] = NOBODY
    registers[at + 13] = NOBODY


@kernel
def _write_ball(match, registers, at):
    ball = match.ball
    _write_motion(ball, ball.vx, ball.vy, registers, at)
    registers[at + 6 : at + 12] = 0.0
    registers[at + 12] = NOBODY
    registers[at + 13] = NOBODY
    if match.reported_owner != NOBODY:
        registers[at + 12] = match.players[match.reported_owner].team
        registers[at + 13] = match.players[match.reported_owner].shirt


@kernel
def _write_motion(body, toward_x, toward_y, registers, at):
    """Write place, heading, velocity and speed of a player or the ball."""
    vx, vy = body.vx / METRES_PER_X, body.vy / METRES_PER_Y
    registers[at] = body.x / METRES_PER_X
    registers[at + 1] = body.y / METRES_PER_Y
    registers[at + 2] = heading(toward_x / METRES_PER_X, toward_y / METRES_PER_Y)
    registers[at + 3] = vx
    registers[at + 4] = vy
    registers[at + 5] = math.sqrt(vx * vx + vy * vy)


@kernel
def heading(x, y):
    """Return the heading of (x, y) in [0, 2π); 0 for no direction."""
    if x == 0.0 and y == 0.0:
        return 0.0
    angle = math.atan2(-x, y)
    return angle if angle >= 0.0 else angle + 2.0 * math.pi
