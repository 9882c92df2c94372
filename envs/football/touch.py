"""What a touch does to the ball: it is taken, or bounces off.

Read next: `hands`, for keepers; `contacts`, where it is decided who touches it how.
"""

from __future__ import annotations

import math

from envs.football.constants import BALL_RADIUS, NOBODY
from envs.football.offside import whistled
from envs.football.possession import lose_ball
from scenic_lite.jit import kernel

BLOCK_KEEP = 0.35  # share of its speed that a blocked ball keeps
MISS_WAIT = 0.5  # s


@kernel
def take(match, i):
    """Give player i the ball at his feet, moving with him, unless he is offside."""
    if whistled(match, i):
        return
    player, ball = match.players[i], match.ball
    lose_ball(match)
    ball.vx, ball.vy, ball.vz = player.vx, player.vy, 0.0
    ball.spin_x, ball.spin_y = ball.vx, ball.vy
    ball.z = BALL_RADIUS
    match.saver = NOBODY
    match.carrier = i
    match.last_touch = i
    match.kicked = False


@kernel
def deflect(match, i, keep):
    """Let the ball bounce off player i's body, keeping this share of its speed."""
    if whistled(match, i):
        return
    player, ball = match.players[i], match.ball
    dx, dy = ball.x - player.x, ball.y - player.y
    distance = math.sqrt(dx * dx + dy * dy) + 1e-9
    inward = (ball.vx * dx + ball.vy * dy) / distance
    if inward < 0.0:
        ball.vx -= 2.0 * inward * dx / distance
        ball.vy -= 2.0 * inward * dy / distance
    ball.vx *= keep
    ball.vy *= keep
    ball.spin_x, ball.spin_y = ball.vx, ball.vy
    player.touch_wait = MISS_WAIT
    match.last_touch = i
    match.kicked = False
    match.saver = NOBODY
