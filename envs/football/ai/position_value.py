"""How good it is to have the ball somewhere: ground gained, room ahead, room around.

Read next: `ai.passing`, which compares mates by it.
"""

from __future__ import annotations

import math

from envs.football.constants import HALF_LENGTH
from envs.football.physics.pitch import attacked_goal_x
from envs.football.physics.vectors import length, squared_apart
from scenic_lite.kernels.jit import kernel

PROGRESS_LEAST, PROGRESS_MOST = 2.0, 8.0  # weight of ground, for slots at the back and at the front
ROOM_AHEAD, ROOM = 0.4, 0.3  # weights
AHEAD_RANGE, ROOM_RANGE = 20.0, 10.0  # m
AHEAD_WIDTH = 0.5  # tangent of half the angle that counts as ahead


@kernel
def eagerness(player):
    """Return the weight of ground gained for a player: the further forward his slot, the greater."""
    return PROGRESS_LEAST + (PROGRESS_MOST - PROGRESS_LEAST) * 0.5 * (1.0 + player.slot_x)


@kernel
def position_value(match, player, x, y):
    """Rate for a player's team that the ball is at (x, y), with the weight that the player himself gives to ground."""
    goal_x = attacked_goal_x(player.team)
    to_x, to_y = goal_x - x, -y
    to_goal = length(to_x, to_y) + 1e-9
    ahead, around = AHEAD_RANGE, ROOM_RANGE
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == player.team:
            continue
        dx, dy = rival.x - x, rival.y - y
        squared = dx * dx + dy * dy
        if squared > AHEAD_RANGE * AHEAD_RANGE:
            continue
        distance = math.sqrt(squared)
        around = min(around, distance)
        along = (dx * to_x + dy * to_y) / to_goal
        if along > 0.0 and abs(dx * to_y - dy * to_x) < AHEAD_WIDTH * along * to_goal:
            ahead = min(ahead, distance)
    ground = 1.0 - to_goal / (2.0 * HALF_LENGTH)
    return eagerness(player) * ground + ROOM_AHEAD * ahead / AHEAD_RANGE + ROOM * around / ROOM_RANGE


@kernel
def nearest_opponent(match, player):
    """Return the distance in m to a player's nearest opponent."""
    nearest = math.inf
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team != player.team:
            nearest = min(nearest, squared_apart(player, rival.x, rival.y))
    return math.sqrt(nearest)
