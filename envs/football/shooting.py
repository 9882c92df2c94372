"""Shots of the built-in AI: from where, at which part of the goal, how hard.

Read next: `kicks`, which carries shots out.
"""

from __future__ import annotations

import math

from envs.football.constants import FRAMES, SHOT
from envs.football.passing import ask_kick
from envs.football.situation import attacked_goal_x
from envs.football.vectors import length
from scenic_lite.jit import kernel
from scenic_lite.stream import uniform

SHOT_RANGE, SHOT_SPOT = 14.0, 7.0  # m around a spot this far before the goal
FREE_RANGE = 7.0  # m around it for whom no opponent stands before: he goes on for as long
SHOT_CHANCE = 0.5  # sqrt(odds) + U(0, 0.5) above this, in any frame, shoots
CORNER_AIM = 3.0  # m off the middle
LANE_NARROW, LANE_WIDE = 0.4, 1.6  # m from an opponent to the lane: no odds, full odds
POWER_STEPS = 3.0  # steps for which the button would be held, at most


@kernel
def consider_shot(match, i):
    """Shoot at the best of both corners and the middle if its lane is free enough; return whether."""
    player = match.players[i]
    goal_x = attacked_goal_x(player)
    spot_x = goal_x - math.copysign(SHOT_SPOT, goal_x)
    if length(spot_x - player.x, player.y) > (FREE_RANGE if alone(match, player, goal_x) else SHOT_RANGE):
        return False
    far_y = -math.copysign(CORNER_AIM, player.y if player.y != 0.0 else goal_x)
    best, best_y = lane_odds(match, player, goal_x, 0.0), 0.0
    for aim_y in (far_y, -far_y):
        odds = lane_odds(match, player, goal_x, aim_y)
        if odds > best:
            best, best_y = odds, aim_y
    luck = uniform(match) ** (1.0 / FRAMES)  # the best of a frame's draws each
    if math.sqrt(best) + 0.5 * luck < SHOT_CHANCE:
        return False
    ask_kick(player, SHOT, goal_x, best_y)
    player.kick_held = 1 + int(POWER_STEPS * uniform(match) + 0.5)
    return True


@kernel
def alone(match, player, goal_x):
    """Tell whether no opponent is closer to the goal that a player attacks than he is."""
    own = length(goal_x - player.x, player.y)
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team != player.team and length(goal_x - rival.x, rival.y) < own:
            return False
    return True


@kernel
def lane_odds(match, player, x, y):
    """Odds in [0, 1] that no opponent of a player stands in the lane from him to (x, y)."""
    dx, dy = x - player.x, y - player.y
    distance = length(dx, dy) + 1e-9
    widest = LANE_WIDE
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == player.team:
            continue
        to_x, to_y = rival.x - player.x, rival.y - player.y
        along = (to_x * dx + to_y * dy) / distance
        if 0.0 < along < distance:
            widest = min(widest, abs(to_x * dy - to_y * dx) / distance)
    return min(max((widest - LANE_NARROW) / (LANE_WIDE - LANE_NARROW), 0.0), 1.0)
