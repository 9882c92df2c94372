"""Shots of the built-in AI: from where, at which part of the goal, how hard.

The law and its numbers are those documented of Google Research Football. Read next: `skills.kicks`, which carries
shots out.
"""

from __future__ import annotations

import math

from envs.football.ai.interception import danger
from envs.football.ai.passing import ask_kick
from envs.football.constants import FRAMES, SHOT
from envs.football.physics.pitch import attacked_goal_x
from envs.football.physics.vectors import length, toward
from envs.football.skills.kicks import GAUGE
from envs.football.skills.shots import SHOT_SKILL
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

SHOT_RANGE, SHOT_SPOT = 12.7, 7.0  # m around a spot this far before the goal
SHOT_CHANCE = 0.5  # sqrt(odds) + U(0, 0.5) above this, in any frame, shoots
SPRINTING, STRIDE_FITS = 6.0, 0.5  # m/s; chance per step that a sprinter who leads the ball can shoot
CORNER, CORNER_AIM, BEHIND_LINE = 3.6, 3.5, 1.0  # m off the middle: of the lane, of the aim; and behind the line
LANE_LEAD, FASTER_THAN_PASSES = 0.12, 3.0  # s by which the shooter's run is led; a shot's speed

# How it is struck
RUN_LEAD, AIM_SHARE, RUN_SHARE, FULL_SPEED = 0.2, 0.7, 0.3, 8.0  # s; shares of aim, and of run at this speed, m/s
POWER_LEAST, POWER_NEAR, POWER_FAR, FAR = 0.7, 0.6, 0.4, 32.0  # of the most; shares; m to the goal


@kernel
def consider_shot(match, i):
    """Shoot at the best of both corners and the middle if its lane is free enough; return whether."""
    player = match.players[i]
    goal_x = attacked_goal_x(player.team)
    spot_x = goal_x - math.copysign(SHOT_SPOT, goal_x)
    if length(spot_x - player.x, player.y) > SHOT_RANGE:
        return False
    if match.carrier == i and length(player.vx, player.vy) > SPRINTING and uniform(match) > STRIDE_FITS:
        return False
    far_y = -math.copysign(1.0, player.y if player.y != 0.0 else goal_x)
    best, best_y = lane_odds(match, player, goal_x, 0.0), 0.0
    for side in (far_y, -far_y):
        odds = lane_odds(match, player, goal_x, side * CORNER)
        if odds > best:
            best, best_y = odds, side * CORNER_AIM
    luck = uniform(match) ** (1.0 / FRAMES)  # the best of a frame's draws each
    if math.sqrt(best) + 0.5 * luck < SHOT_CHANCE:
        return False
    shoot(match, player, goal_x, best_y)
    return True


@kernel
def shoot(match, player, goal_x, y):
    """Ask for a shot at y on the goal line: turned away from the run, which would drag it, and so often too far."""
    miss = 1.0 - SHOT_SKILL[player.shirt % len(SHOT_SKILL)] * player.skill
    from_x, from_y = player.x + RUN_LEAD * player.vx, player.y + RUN_LEAD * player.vy
    line_x = goal_x + math.copysign(BEHIND_LINE, goal_x)
    miss *= (2.0 * uniform(match) - 1.0) * math.copysign(1.0, goal_x)  # turned with the pitch
    ux, uy = toward(line_x - from_x, y + miss - from_y)
    run = RUN_SHARE * length(player.vx, player.vy) / FULL_SPEED
    ux, uy = toward(AIM_SHARE * ux - run * player.facing_x, AIM_SHARE * uy - run * player.facing_y)
    distance = length(line_x - from_x, y - from_y)
    ask_kick(player, SHOT, from_x + distance * ux, from_y + distance * uy)
    far = min(length(goal_x - player.x, player.y) / FAR, 1.0)
    power = (POWER_LEAST + (1.0 - POWER_LEAST) * uniform(match)) * (POWER_NEAR + POWER_FAR * far)
    gauge = power ** (1.0 / GAUGE.shot_power)
    player.kick_held = int((GAUGE.least + GAUGE.range * gauge) / GAUGE.step + uniform(match))


@kernel
def lane_odds(match, player, x, y):
    """Return the odds in [0, 1] that a shot at (x, y) gets past the opponents of a player."""
    from_x, from_y = player.x + LANE_LEAD * player.vx, player.y + LANE_LEAD * player.vy
    return max(1.0 - danger(match, player.team, from_x, from_y, x, y, 0.0, FASTER_THAN_PASSES), 0.0)
