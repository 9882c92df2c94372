"""What a touch does to the ball: it is taken, held, bounces off, or is parried.

Read next: `contacts`, where it is decided who touches it how.
"""

from __future__ import annotations

import math

from envs.football.constants import BALL_RADIUS, NOBODY
from envs.football.offside import whistled
from envs.football.possession import lose_ball
from envs.football.vectors import length
from scenic_lite.jit import kernel
from scenic_lite.stream import uniform

BLOCK_KEEP = 0.35  # share of its speed that a blocked ball keeps
MISS_WAIT = 0.5  # s
PARRY_KEEP, PARRY_LIFT = 0.3, 1.2  # share of speed; m/s
PARRY_ASIDE, PARRY_SPREAD = 0.5, 1.5  # tangent of the angle off straight back
HANDS_HEIGHT = 1.2  # m, a ball that is held
HOLD_STEPS, HOLD_SPREAD = 9, 7  # steps until a keeper kicks out, and how much they vary


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
    match.saver = NOBODY


@kernel
def hold(match, i):
    """Give keeper i the ball in his hands."""
    take(match, i)
    if match.carrier != i:
        return
    match.holder = i
    match.hold_wait = HOLD_STEPS + int(HOLD_SPREAD * uniform(match))
    carry_in_hands(match)


@kernel
def carry_in_hands(match):
    """Keep a held ball in its holder's hands."""
    player, ball = match.players[match.holder], match.ball
    ball.x, ball.y = player.x + 0.3 * player.facing_x, player.y + 0.3 * player.facing_y
    ball.z = HANDS_HEIGHT
    ball.vx, ball.vy, ball.vz = player.vx, player.vy, 0.0


@kernel
def parry(match, i):
    """Let keeper i push the ball away, forward and to the side from which it came."""
    if whistled(match, i):
        return
    player, ball = match.players[i], match.ball
    speed = PARRY_KEEP * length(ball.vx, ball.vy)
    side = ball.y - player.y
    back = -1.0 if ball.vx > 0.0 else 1.0
    sideways = math.copysign(PARRY_ASIDE + PARRY_SPREAD * uniform(match), side)
    size = math.sqrt(1.0 + sideways * sideways)
    ball.vx, ball.vy, ball.vz = speed * back / size, speed * sideways / size, PARRY_LIFT
    ball.spin_x, ball.spin_y = 0.0, 0.0
    player.touch_wait = MISS_WAIT
    match.last_touch = i
    match.saver = NOBODY
