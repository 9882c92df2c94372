"""How likely opponents are to intercept a ball that is played along a lane.

The law and its numbers are documented by Google Research Football. Read next: `ai.passing`.
"""

from __future__ import annotations

from typing import NamedTuple

from regista.envs.football.physics.vectors import length
from regista.kernels.jit import kernel


class Interception(NamedTuple):
    """Parameters for whether an opponent reaches a lane before the ball."""

    lead: float = 0.2  # s by which the opponent's run is extrapolated
    lane_end: float = 1.2  # share of the lane's length, up to which opponents are dangerous
    ball_delay: float = 0.7  # s that a pass of any length takes to the end of its lane,
    ball_time: float = 0.03  # s/m, and additionally per m of length
    speed: float = 8.0  # m/s of the opponent
    start: float = 1.0  # m added to the opponent's way
    in_time: float = 0.5  # s; the danger if opponent and ball arrive at the same time


# Documented by Google Research Football; checked by `lab.benchmarks --suite grf`, families passes and matches.
INTERCEPTION = Interception()


@kernel
def danger(match, team, from_x, from_y, x, y, overhead, faster):
    """Sum over the opponents of `team` how likely each of them reaches the lane to (x, y) before the ball, 0 to 1.

    The ball is out of reach along the first share `overhead` of the lane, and `faster` times as fast as a pass.
    """
    dx, dy = x - from_x, y - from_y
    distance = length(dx, dy) + 1e-9
    total = 0.0
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == team:
            continue
        to_x, to_y = rival.x + INTERCEPTION.lead * rival.vx - from_x, rival.y + INTERCEPTION.lead * rival.vy - from_y
        share = (to_x * dx + to_y * dy) / (distance * distance)
        if overhead <= share <= INTERCEPTION.lane_end:
            away = abs(to_x * dy - to_y * dx) / distance
            ball_time = (INTERCEPTION.ball_delay + INTERCEPTION.ball_time * min(share, 1.0) * distance) * share / faster
            rival_time = (away + INTERCEPTION.start) / INTERCEPTION.speed
            total += min(max(ball_time - rival_time + INTERCEPTION.in_time, 0.0), 1.0)
    return total
