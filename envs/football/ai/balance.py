"""The balance of a match over the last seconds: each team's share of possession, and the ball's mean position.

A team's share of possession slowly follows a ratio: the other team's time to the ball divided by its own. It ranges
from 0.5 (the other team has the ball) to 1.5 (this team has it). This is Google Research Football's law, and all
players without the ball depend on it. Read next: `ai.formation`.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import LEFT, NOBODY, NORMAL, RIGHT, STEP
from regista.envs.football.physics.pitch import forward
from regista.envs.football.state import BALL_MEMORY
from regista.kernels.jit import kernel

NO_POSSESSION, FULL_POSSESSION = 0.5, 1.5
POSSESSION_SLACK = 1.5  # s added to both teams' times to the ball before their comparison
POSSESSION_TIME = 2.0  # s, time constant with which the share follows present possession
TREND_STEPS = 60  # steps over which the possession trend is averaged
PACE_TIME = 6.0  # s over which a player's speed is averaged


@kernel
def remember(match):
    """Update the averages of the ball's position, of possession, and of every player's speed."""
    remember_ball(match)
    update_possession_share(match)
    for i in range(match.num_players):
        player = match.players[i]
        speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
        player.mean_speed += (speed - player.mean_speed) * (STEP / PACE_TIME)


@kernel
def remember_ball(match):
    """Add the ball's position to the sums for `mean_ball`; a restart clears them."""
    if match.game_mode != NORMAL:
        match.remembered = 0
    match.remembered += 1
    now, before = match.remembered % BALL_MEMORY, (match.remembered - 1) % BALL_MEMORY
    if match.remembered == 1:
        match.ball_sums[before, 0], match.ball_sums[before, 1] = 0.0, 0.0
    match.ball_sums[now, 0] = match.ball_sums[before, 0] + match.ball.x
    match.ball_sums[now, 1] = match.ball_sums[before, 1] + match.ball.y


@kernel
def mean_ball(match, seconds, axis):
    """Return the ball's x (axis 0) or y in m, averaged over the last `seconds`, at most 4, and not across a restart."""
    steps = min(max(int(seconds / STEP + 0.5), 1), BALL_MEMORY - 1, match.remembered)
    now = match.remembered % BALL_MEMORY
    then = now - steps if now >= steps else now - steps + BALL_MEMORY
    return (match.ball_sums[now, axis] - match.ball_sums[then, axis]) / steps


@kernel
def update_possession_share(match):
    """Update both teams' shares of possession by their times to the ball; a keeper holding it or a taker has all."""
    sure = NOBODY
    if match.keeper_holding != NOBODY:
        sure = match.players[match.keeper_holding].team
    elif match.game_mode != NORMAL:
        sure = match.restart_team
    for team in (LEFT, RIGHT):
        if sure != NOBODY:
            match.hold[team] = FULL_POSSESSION if sure == team else NO_POSSESSION
            continue
        now = (match.arrival[1 - team] + POSSESSION_SLACK) / (match.arrival[team] + POSSESSION_SLACK)
        now = min(max(now, NO_POSSESSION), FULL_POSSESSION)
        match.hold[team] += (now - match.hold[team]) * (1.0 - math.exp(-STEP / POSSESSION_TIME))
    difference = match.hold[LEFT] - match.hold[RIGHT]
    match.lean += (difference - match.lean) / min(match.remembered, TREND_STEPS)


@kernel
def possession_trend(match, team):
    """Return how far, -1 to 1, the possession of the last seconds moves the block of `team` forward.

    The block moves forward when the team lacks the ball, as measured in scenes in which only the slot determines a
    defender's position.
    """
    return -forward(team) * match.lean
