"""How fast a built-in player goes where he wants to be: walking, running or sprinting, and lazily far from the ball.

Read next: `ai.support`, `ai.defence`.
"""

from __future__ import annotations

import math

from envs.football.constants import DRIBBLE_SPEED, RUN_SPEED
from envs.football.physics.vectors import length
from scenic_lite.kernels.jit import kernel

URGENCY = 2.6  # 1/s: wanted speed per distance to go
STANDS, WALKS, RUNS = 1.75, 4.25, 6.5  # m/s, desired speeds up to which he stands, walks, runs
LAZY_FROM, LAZY_TO, LAZINESS = 20.0, 65.0, 0.75  # m to the ball; share of the desired speed that is lost
TIRED_LAZINESS = 0.3
FULL_REACTION, SKILLED_REACTION = 0.16, 0.06  # s, at difficulty 0 and 1
SKILL_RANGE = 0.7  # of `skill`, from difficulty 0 to 1


@kernel
def head_for(match, player, x, y):
    """Want to be at (x, y), with the effort that the distance and the ball's call for."""
    dx, dy = x - player.x, y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    ball = match.ball
    far = (length(ball.x - player.x, ball.y - player.y) - LAZY_FROM) / (LAZY_TO - LAZY_FROM)
    desired = (
        URGENCY * distance * (1.0 - LAZINESS * min(max(far, 0.0), 1.0)) * (1.0 - TIRED_LAZINESS * player.tiredness)
    )
    go(player, dx, dy, gait_speed(player, desired))


@kernel
def gait_speed(player, desired):
    """Return the speed in m/s of the body's gaits that is nearest to a desired one."""
    if desired < STANDS:
        return 0.0
    if desired < WALKS:
        return DRIBBLE_SPEED
    return RUN_SPEED if desired < RUNS else player.top_speed


@kernel
def go(player, dx, dy, speed):
    """Want to move along (dx, dy) at this speed."""
    size = math.sqrt(dx * dx + dy * dy)
    share = speed / size if size > 0.05 else 0.0
    player.desired_vx, player.desired_vy = share * dx, share * dy


@kernel
def reaction_time(player):
    """Return the seconds by which a player is behind with what he sees of others."""
    ease = (player.skill - (1.0 - SKILL_RANGE)) / SKILL_RANGE
    return FULL_REACTION + (SKILLED_REACTION - FULL_REACTION) * ease
