"""Shots of the built-in AI: position, target in the goal, and power.

The law and its numbers are documented by Google Research Football. Read next: `skills.kicks`, which executes shots.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.ai.interception import danger
from regista.envs.football.ai.passing import ask_kick
from regista.envs.football.constants import FRAMES, SHOT
from regista.envs.football.physics.pitch import attacked_goal_x
from regista.envs.football.physics.vectors import length, toward
from regista.envs.football.skills.kicks import GAUGE
from regista.envs.football.skills.shots import SHOT_SKILL
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class When(NamedTuple):
    """Conditions for a shot."""

    spot: float = 7.0  # m in front of the goal, the center of the shooting area
    range: float = 12.7  # m, radius of this area
    chance: float = 0.5  # a player shoots if sqrt(odds) + U(0, 0.5) exceeds this in any frame
    luck: float = 0.5  # maximum of this uniform draw
    sprinting: float = 6.0  # m/s; a faster carrier sprints
    stride_fits: float = 0.5  # chance per step that the stride allows a shot


class Lane(NamedTuple):
    """The corners of the goal, and the lanes of shots to them."""

    corner: float = 3.6  # m from the middle of the goal to the corner whose lane is rated
    aim: float = 3.5  # m from the middle of the goal to the target at this corner
    lead: float = 0.12  # s by which the shooter's run is extrapolated
    faster: float = 3.0  # factor of the speed of a pass


class Strike(NamedTuple):
    """The parameters of a requested shot."""

    behind_line: float = 1.0  # m behind the goal line, where the target is
    run_lead: float = 0.2  # s by which the shooter's run is extrapolated
    aim_share: float = 0.7  # weight of the direction to the target
    run_share: float = 0.3  # weight of the run, subtracted, at a speed of
    full_speed: float = 8.0  # m/s
    power_least: float = 0.7  # random share of the power, at least
    power_near: float = 0.6  # share of the maximum power at distance 0,
    power_far: float = 0.4  # and this added at a distance of
    far: float = 32.0  # m to the goal


# Documented by Google Research Football; checked by `lab.benchmarks --suite grf`, families matches and academy.
WHEN, LANE, STRIKE = When(), Lane(), Strike()


@kernel
def consider_shot(match, i):
    """Shoot at the best of both corners and the middle if its lane is free enough; return whether it shoots."""
    player = match.players[i]
    goal_x = attacked_goal_x(player.team)
    spot_x = goal_x - math.copysign(WHEN.spot, goal_x)
    if length(spot_x - player.x, player.y) > WHEN.range:
        return False
    if match.carrier == i and length(player.vx, player.vy) > WHEN.sprinting and uniform(match) > WHEN.stride_fits:
        return False
    far_y = -math.copysign(1.0, player.y if player.y != 0.0 else goal_x)
    best, best_y = lane_odds(match, player, goal_x, 0.0), 0.0
    for side in (far_y, -far_y):
        odds = lane_odds(match, player, goal_x, side * LANE.corner)
        if odds > best:
            best, best_y = odds, side * LANE.aim
    luck = uniform(match) ** (1.0 / FRAMES)  # the maximum of the draws of all frames
    if math.sqrt(best) + WHEN.luck * luck < WHEN.chance:
        return False
    shoot(match, player, goal_x, best_y)
    return True


@kernel
def shoot(match, player, goal_x, y):
    """Request a shot at y on the goal line, turned away from the run to compensate for its drag, often by too much."""
    miss = 1.0 - SHOT_SKILL[player.shirt % len(SHOT_SKILL)] * player.skill
    from_x, from_y = player.x + STRIKE.run_lead * player.vx, player.y + STRIKE.run_lead * player.vy
    line_x = goal_x + math.copysign(STRIKE.behind_line, goal_x)
    miss *= (2.0 * uniform(match) - 1.0) * math.copysign(1.0, goal_x)  # rotated with the pitch
    ux, uy = toward(line_x - from_x, y + miss - from_y)
    run = STRIKE.run_share * length(player.vx, player.vy) / STRIKE.full_speed
    ux, uy = toward(STRIKE.aim_share * ux - run * player.facing_x, STRIKE.aim_share * uy - run * player.facing_y)
    distance = length(line_x - from_x, y - from_y)
    ask_kick(player, SHOT, player.x + distance * ux, player.y + distance * uy)
    far = min(length(goal_x - player.x, player.y) / STRIKE.far, 1.0)
    power = (STRIKE.power_least + (1.0 - STRIKE.power_least) * uniform(match)) * (
        STRIKE.power_near + STRIKE.power_far * far
    )
    gauge = power ** (1.0 / GAUGE.shot_power)
    player.kick_held = int((GAUGE.least + GAUGE.range * gauge) / GAUGE.step + uniform(match))


@kernel
def lane_odds(match, player, x, y):
    """Return the odds in [0, 1] that a shot at (x, y) gets past the opponents of a player."""
    from_x, from_y = player.x + LANE.lead * player.vx, player.y + LANE.lead * player.vy
    return max(1.0 - danger(match, player.team, from_x, from_y, x, y, 0.0, LANE.faster), 0.0)
