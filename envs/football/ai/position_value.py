"""The value of possession at a position: ground gained, free space ahead, free space around.

Read next: `ai.passing`, which compares teammates by it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.ai.formation import MINDSET
from regista.envs.football.constants import HALF_LENGTH
from regista.envs.football.physics.pitch import attacked_goal_x
from regista.envs.football.physics.vectors import length, squared_apart
from regista.kernels.jit import kernel


class Value(NamedTuple):
    """The value of a position."""

    progress_least: float = 2.0  # weight of ground gained, for a defender
    progress_most: float = 8.0  # the same for a forward
    ahead: float = 0.4  # weight of free space ahead
    ahead_range: float = 20.0  # m
    ahead_width: float = 0.5  # tangent of half the angle that counts as ahead
    around: float = 0.3  # weight of free space all around
    around_range: float = 10.0  # m


# Documented by Google Research Football; checked by `lab.benchmarks --suite grf`, family matches.
VALUE = Value()


@kernel
def eagerness(match, player):
    """Return a player's weight of ground gained: larger for attackers."""
    attacker = MINDSET[match.players[player.post].role]
    return VALUE.progress_least + (VALUE.progress_most - VALUE.progress_least) * attacker


@kernel
def position_value(match, player, x, y):
    """Return the value of the ball at (x, y) for a player's team, with the player's own weight of ground gained."""
    goal_x = attacked_goal_x(player.team)
    to_x, to_y = goal_x - x, -y
    to_goal = length(to_x, to_y) + 1e-9
    ahead, around = VALUE.ahead_range, VALUE.around_range
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == player.team:
            continue
        dx, dy = rival.x - x, rival.y - y
        squared = dx * dx + dy * dy
        if squared > VALUE.ahead_range * VALUE.ahead_range:
            continue
        distance = math.sqrt(squared)
        around = min(around, distance)
        along = (dx * to_x + dy * to_y) / to_goal
        if along > 0.0 and abs(dx * to_y - dy * to_x) < VALUE.ahead_width * along * to_goal:
            ahead = min(ahead, distance)
    ground = 1.0 - to_goal / (2.0 * HALF_LENGTH)
    return (
        eagerness(match, player) * ground
        + VALUE.ahead * ahead / VALUE.ahead_range
        + VALUE.around * around / VALUE.around_range
    )


@kernel
def nearest_opponent(match, player):
    """Return the distance in m to a player's nearest opponent."""
    nearest = math.inf
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team != player.team:
            nearest = min(nearest, squared_apart(player, rival.x, rival.y))
    return math.sqrt(nearest)
