"""How fast a built-in player goes where he wants to be: walking, running or sprinting, and lazily far from the ball.

Read next: `ai.support`, `ai.defence`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from envs.football.constants import DRIBBLE_SPEED, RUN_SPEED
from envs.football.physics.vectors import length
from scenic_lite.kernels.jit import kernel


class GaitChoice(NamedTuple):
    """Which of the body's gaits suits a desired speed: up to so many m/s he ..."""

    stands: float = 1.75  # m/s
    walks: float = 4.25  # m/s
    runs: float = 6.5  # m/s; above it he sprints


class Effort(NamedTuple):
    """How fast he wants to be where he goes."""

    urgency: float = 2.6  # 1/s: speed per distance to go
    lazy_from: float = 20.0  # m to the ball
    lazy_to: float = 65.0  # m
    laziness: float = 0.75  # share of the speed that is lost from there on
    tired: float = 0.3  # share of it that the tired lose


class Reaction(NamedTuple):
    """By how much he is behind with what he sees of others."""

    unskilled: float = 0.16  # s, at difficulty 0
    skilled: float = 0.06  # s, at difficulty 1
    skill_range: float = 0.7  # of `skill`, from difficulty 0 to 1


# Documented of Google Research Football; checked by `regista benchmark --suite grf`, families matches and academy.
GAIT_CHOICE, EFFORT, REACTION = GaitChoice(), Effort(), Reaction()


@kernel
def head_for(match, player, x, y):
    """Want to be at (x, y), with the effort that the distance and the ball's call for."""
    dx, dy = x - player.x, y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    ball = match.ball
    far = (length(ball.x - player.x, ball.y - player.y) - EFFORT.lazy_from) / (EFFORT.lazy_to - EFFORT.lazy_from)
    desired = (
        EFFORT.urgency
        * distance
        * (1.0 - EFFORT.laziness * min(max(far, 0.0), 1.0))
        * (1.0 - EFFORT.tired * player.tiredness)
    )
    go(player, dx, dy, gait_speed(player, desired))


@kernel
def gait_speed(player, desired):
    """Return the speed in m/s of the body's gaits that is nearest to a desired one."""
    if desired < GAIT_CHOICE.stands:
        return 0.0
    if desired < GAIT_CHOICE.walks:
        return DRIBBLE_SPEED
    return RUN_SPEED if desired < GAIT_CHOICE.runs else player.top_speed


@kernel
def go(player, dx, dy, speed):
    """Want to move along (dx, dy) at this speed."""
    size = math.sqrt(dx * dx + dy * dy)
    share = speed / size if size > 0.05 else 0.0
    player.desired_vx, player.desired_vy = share * dx, share * dy


@kernel
def reaction_time(player):
    """Return the seconds by which a player is behind with what he sees of others."""
    ease = (player.skill - (1.0 - REACTION.skill_range)) / REACTION.skill_range
    return player.reaction_time * (REACTION.unskilled + (REACTION.skilled - REACTION.unskilled) * ease)
