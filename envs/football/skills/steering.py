"""Steering: the velocity that leads a player to a place, to a free ball or to one that is led; and slides.

Read next: `skills.tackles`, what a slide does; `control.keys` and `ai.decide`, who steers.
"""

from __future__ import annotations

import math

from envs.football.constants import NOBODY
from envs.football.physics.motion import SLIDE
from envs.football.physics.possession import look_ahead, time_to_meet, travelled
from envs.football.physics.vectors import apart, length
from scenic_lite.kernels.jit import kernel

HUNT_LEAD = 1.2  # s at most by which a carrier's run is led
ROUND, OVERTAKE = 1.0, 0.4  # m beside a body that is run round, and s ahead of it
SLIDE_KEEPS = 0.9  # of the run's speed


@kernel
def slide(match, i):
    """Throw player i into a slide along his run; nothing happens while his team has the ball."""
    player = match.players[i]
    if player.down_wait > 0.0 or match.game_mode != 0:
        return
    if match.carrier != NOBODY and match.players[match.carrier].team == player.team:
        return
    speed = SLIDE_KEEPS * length(player.vx, player.vy)
    player.vx, player.vy = speed * player.facing_x, speed * player.facing_y
    player.is_sliding, player.down_wait = True, SLIDE.time


@kernel
def chase(match, i, speed):
    """Want to run at this speed to where the ball can be met."""
    player, ball, ahead = match.players[i], match.ball, look_ahead(match.ball)
    share = 0.0
    if ahead.speed > 0.5:
        share = travelled(ahead, time_to_meet(match, i, ahead)) / ahead.speed
    run_to(player, ball.x + share * ball.vx, ball.y + share * ball.vy, speed)


@kernel
def run_to(player, x, y, speed):
    """Want to run to a place, slowing down over the last stride."""
    dx, dy = x - player.x, y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    if distance < 0.05:
        player.desired_vx, player.desired_vy = 0.0, 0.0
        return
    speed = min(speed, 4.0 * distance + 0.5)
    player.desired_vx, player.desired_vy = dx / distance * speed, dy / distance * speed


@kernel
def go_for_ball(match, i, speed):
    """Run to where the carried ball will be, round the carrier's body if that is in the way."""
    player, ball = match.players[i], match.ball
    carrier = match.players[match.carrier]
    distance = apart(ball, player)
    time = min(distance / 8.0, HUNT_LEAD)
    x, y = ball.x + time * ball.vx, ball.y + time * ball.vy
    ball_x, ball_y = ball.x - carrier.x, ball.y - carrier.y
    from_x, from_y = player.x - carrier.x, player.y - carrier.y
    if ball_x * from_x + ball_y * from_y < 0.0 and distance < 3.0:
        size = length(from_x, from_y) + 1e-9
        side = ROUND if from_x * ball_y - from_y * ball_x >= 0.0 else -ROUND
        x = carrier.x - side * from_y / size + OVERTAKE * carrier.vx
        y = carrier.y + side * from_x / size + OVERTAKE * carrier.vy
    dx, dy = x - player.x, y - player.y
    size = length(dx, dy) + 1e-9
    player.desired_vx, player.desired_vy = dx / size * speed, dy / size * speed
