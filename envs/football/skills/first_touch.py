"""A free ball brought under control: how hard it is, and where the first touch sends it.

Nobody misses a ball that he reaches, but a hard one jumps off him, and goes on as it came if an opponent has only
just kicked it. The law and its numbers are those documented of Google Research Football. Read next: `skills.contacts`.
"""

from __future__ import annotations

from envs.football.constants import NOBODY
from envs.football.physics.vectors import length
from envs.football.skills.touch import take
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

FAST_FROM, FAST_RANGE, FAST_POWER, FAST_WEIGHT = 10.0, 40.0, 1.5, 5.0  # m/s relative to the player
FAR_AHEAD, FAR_FROM, FAR_RANGE, FAR_WEIGHT = 0.2, 0.7, 0.6, 2.0  # m from a place ahead of the body
FAR_AWAY_WEIGHT = 4.0  # of that, in how far the ball jumps
SURPRISE_TIME, SURPRISE_POWER, SURPRISE_WEIGHT = 0.73, 0.6, 5.0  # s after an opponent's kick
SURPRISE_KEEP = 0.1  # of that, in how much the ball goes on as it came
CONTROL = 0.75  # 1 less half of the ball control that players have
REST = 0.38  # m ahead of a standing player, where he wants the ball
JUMP_SCALE, JUMP_POWER, LEAST_GAP = 0.215, 0.7, 0.2  # m of way to go, into m/s
LIFT = 4.0  # m/s
LOOSE = 0.5  # a ball that jumps further off than this is anybody's
TOUCH_AGAIN = 0.3  # s until he can play a ball that he has just stopped


@kernel
def difficulty(match, player):
    """How hard a ball is to play: how far off it jumps, how high, and how much of its way it keeps, each 0 to 1."""
    ball = match.ball
    fast = length(ball.vx - player.vx, ball.vy - player.vy)
    away = length(ball.x - player.x - FAR_AHEAD * player.facing_x, ball.y - player.y - FAR_AHEAD * player.facing_y)
    surprise = SURPRISE_WEIGHT * surprised(match, player) ** SURPRISE_POWER
    if fast <= FAST_FROM and away <= FAR_FROM and surprise == 0.0:
        return 0.0, 0.0, 0.0
    fast = FAST_WEIGHT * min(max((fast - FAST_FROM) / FAST_RANGE, 0.0), 1.0) ** FAST_POWER
    away = FAR_WEIGHT * min(max((away - FAR_FROM) / FAR_RANGE, 0.0), 1.0) ** 2.0
    skill = (1.0 - (1.0 - CONTROL) * player.skill) * (0.5 + 0.5 * uniform(match))
    far_off = skill * (fast + FAR_AWAY_WEIGHT * away + surprise)
    high_off = skill * (2.0 * fast + away + surprise)
    return min(far_off, 1.0), min(high_off, 1.0), skill * min(SURPRISE_KEEP * surprise, 0.9)


@kernel
def surprised(match, player):
    """Share in [0, 1], falling with the time since an opponent's last touch, of what a player can be surprised."""
    if not match.was_kicked or match.last_touch == NOBODY or match.players[match.last_touch].team == player.team:
        return 0.0
    return max(1.0 - match.kick_age / SURPRISE_TIME, 0.0)


@kernel
def cushion(match, i):
    """Let player i stop a free ball: it drops at his feet, or jumps off him as hard as it is to control."""
    player, ball = match.players[i], match.ball
    far_off, high_off, kept = difficulty(match, player)
    vx, vy, vz, z = ball.vx, ball.vy, ball.vz, ball.z
    take(match, i)
    if match.carrier != i:
        return
    to_x = player.x + (REST + far_off) * player.facing_x - ball.x
    to_y = player.y + (REST + far_off) * player.facing_y - ball.y
    gap = length(to_x, to_y) + 1e-9
    push = (max(gap, LEAST_GAP) / JUMP_SCALE) ** JUMP_POWER / gap
    ball.vx = (1.0 - kept) * (player.vx + push * to_x) + kept * vx
    ball.vy = (1.0 - kept) * (player.vy + push * to_y) + kept * vy
    if far_off > LOOSE:
        match.carrier = NOBODY
    ball.z, ball.vz = z, (1.0 - kept) * high_off * (vz + LIFT) + kept * vz
    player.touch_wait = TOUCH_AGAIN
