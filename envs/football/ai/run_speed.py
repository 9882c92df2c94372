"""The speed of a built-in player on the way to its target: a walk, run or sprint, slower far from the ball.

Read next: `ai.support`, `ai.defence`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.ai.formation import MINDSET, between
from regista.envs.football.constants import DRIBBLE_SPEED, RUN_SPEED
from regista.envs.football.physics.vectors import apart
from regista.kernels.jit import kernel


class Effort(NamedTuple):
    """The effort of a player to reach its position."""

    urgency: float = 2.6  # 1/s, desired speed per m of distance
    sprint: float = 8.0  # m/s, up to which the desired speed counts in full
    overflow: float = 0.1  # share of the desired speed above that which counts
    lazy_from: float = 20.0  # m to the opponent on the ball, from which on players slow down
    lazy_to: float = 65.0
    from_tired: float = 0.8  # share of `lazy_from` that tired players lose
    to_tired: float = 0.5
    least_lazy: float = 0.5  # share of the slowing down that does not depend on the role
    breath: float = 1.2  # factor of the share of speed left when out of breath
    breath_curve: float = 0.66


class GaitChoice(NamedTuple):
    """The gait that fits a desired speed, given by the upper limits of standing, walking and running."""

    stands: float = 1.8  # m/s
    walks: float = 4.2  # m/s
    runs: float = 6.0  # m/s; above it a player sprints


class Reaction(NamedTuple):
    """Reaction times: the delay with which a player sees others."""

    unskilled: float = 0.16  # s, at difficulty 0
    skilled: float = 0.06  # s, at difficulty 1
    skill_range: float = 0.7  # range of `skill` from difficulty 0 to 1


# Documented by Google Research Football; family matches of `lab.benchmarks --suite grf`.
EFFORT, GAIT_CHOICE, REACTION = Effort(), GaitChoice(), Reaction()


@kernel
def head_for(match, player, x, y, rival):
    """Desire a velocity to (x, y), with an effort that depends on the distance to the opponent `rival` on the ball."""
    dx, dy = x - player.x, y - player.y
    desired = EFFORT.urgency * math.sqrt(dx * dx + dy * dy)
    if desired >= GAIT_CHOICE.stands:
        desired = lazy_speed(match, player, desired, rival)
    go(player, dx, dy, gait_speed(player, desired))


@kernel
def lazy_speed(match, player, desired, rival):
    """Return the desired speed in m/s, reduced far from the ball, by role, and when out of breath."""
    fresh = 1.0 - player.tiredness
    start = EFFORT.lazy_from * (1.0 - EFFORT.from_tired * player.tiredness)
    end = EFFORT.lazy_to * (1.0 - EFFORT.to_tired * (1.0 - fresh))
    attacker = MINDSET[match.players[player.post].role]
    held = min(max(match.hold[player.team] - 0.5, 0.0), 1.0)
    by_role = attacker + held * (1.0 - 2.0 * attacker)
    lazy = between(apart(player, rival), start, end) * (EFFORT.least_lazy + (1.0 - EFFORT.least_lazy) * by_role)
    speed = min(desired, EFFORT.sprint) + EFFORT.overflow * max(desired - EFFORT.sprint, 0.0)
    speed *= 1.0 - lazy
    if desired >= DRIBBLE_SPEED:
        speed = max(speed, DRIBBLE_SPEED)
    slowest = EFFORT.sprint * (1.0 - lazy)
    if speed <= slowest or gait_speed(player, speed) == gait_speed(player, slowest):
        return speed  # no player is out of breath at this gait; skips a power, which is slow
    breath = min(EFFORT.breath * (1.0 - min(player.mean_speed / EFFORT.sprint, 1.0)) ** EFFORT.breath_curve, 1.0)
    return min(speed, EFFORT.sprint * (1.0 + lazy * (breath - 1.0)))


@kernel
def gait_speed(player, desired):
    """Return the speed in m/s of the gait nearest to a desired one."""
    if desired < GAIT_CHOICE.stands:
        return 0.0
    if desired < GAIT_CHOICE.walks:
        return DRIBBLE_SPEED
    return RUN_SPEED if desired < GAIT_CHOICE.runs else player.top_speed


@kernel
def go(player, dx, dy, speed):
    """Desire a velocity along (dx, dy) at this speed."""
    size = math.sqrt(dx * dx + dy * dy)
    share = speed / size if size > 0.05 else 0.0
    player.desired_vx, player.desired_vy = share * dx, share * dy


@kernel
def reaction_time(player):
    """Return the reaction time of a player in s."""
    ease = (player.skill - (1.0 - REACTION.skill_range)) / REACTION.skill_range
    return player.reaction_time * (REACTION.unskilled + (REACTION.skilled - REACTION.unskilled) * ease)
