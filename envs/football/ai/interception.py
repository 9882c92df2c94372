"""How surely opponents intercept a ball that is played along a lane.

The law and its numbers are those documented of Google Research Football. Read next: `ai.passing`.
"""

from __future__ import annotations

from envs.football.physics.vectors import length
from scenic_lite.kernels.jit import kernel

RIVAL_LEAD = 0.2  # s by which an opponent's run is led
LANE_END = 1.2  # of the lane's length, up to where an opponent endangers it
BALL_DELAY, BALL_TIME = 0.7, 0.03  # s, s/m: how long a pass takes to the end of its lane
RIVAL_SPEED, RIVAL_START = 8.0, 1.0  # m/s; m more to go
IN_TIME = 0.5  # s of danger if opponent and ball are there at once


@kernel
def danger(match, team, from_x, from_y, x, y, overhead, faster):
    """Sum over the opponents of `team` of how surely each is at the lane to (x, y) before the ball, from 0.

    Along its first part, the share `overhead`, the ball is out of their reach; it is `faster` than a pass.
    """
    dx, dy = x - from_x, y - from_y
    distance = length(dx, dy) + 1e-9
    total = 0.0
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == team:
            continue
        to_x, to_y = rival.x + RIVAL_LEAD * rival.vx - from_x, rival.y + RIVAL_LEAD * rival.vy - from_y
        share = (to_x * dx + to_y * dy) / (distance * distance)
        if overhead <= share <= LANE_END:
            away = abs(to_x * dy - to_y * dx) / distance
            ball_time = (BALL_DELAY + BALL_TIME * min(share, 1.0) * distance) * share / faster
            rival_time = (away + RIVAL_START) / RIVAL_SPEED
            total += min(max(ball_time - rival_time + IN_TIME, 0.0), 1.0)
    return total
