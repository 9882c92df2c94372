"""How a match leans: who has had more of the ball, and where it has been, over the last seconds.

A team's hold on the ball follows, slowly, how much sooner it can be there than the other team: 0.5 the others have it,
1.5 this team has. So Google Research Football has it, and all its players without the ball act on it. Read next:
`ai.formation`.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import LEFT, NOBODY, NORMAL, RIGHT, STEP
from regista.envs.football.physics.pitch import forward
from regista.envs.football.state import BALL_MEMORY
from regista.kernels.jit import kernel

NO_POSSESSION, FULL_POSSESSION = 0.5, 1.5
HOLD_SLACK = 1.5  # s added to both teams' times to the ball before they are compared
POSSESSION_TIME = 2.0  # s in which a hold follows what is so now
TREND_STEPS = 60  # steps over which the lean of the match is averaged
PACE_TIME = 6.0  # s over which a player's speed is averaged


@kernel
def remember(match):
    """Take down where the ball is, who has more of it, and how fast everybody has run."""
    remember_ball(match)
    follow_hold(match)
    for i in range(match.num_players):
        player = match.players[i]
        speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
        player.mean_speed += (speed - player.mean_speed) * (STEP / PACE_TIME)


@kernel
def remember_ball(match):
    """Add the ball's place to the sums from which `mean_ball` takes its averages; a restart forgets them."""
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
    """Return the ball's x (axis 0) or y in m, averaged over the last seconds, at most 4, since play was stopped."""
    steps = min(max(int(seconds / STEP + 0.5), 1), BALL_MEMORY - 1, match.remembered)
    now = match.remembered % BALL_MEMORY
    then = now - steps if now >= steps else now - steps + BALL_MEMORY
    return (match.ball_sums[now, axis] - match.ball_sums[then, axis]) / steps


@kernel
def follow_hold(match):
    """Let both teams' holds on the ball follow who can be there first; whoever holds it or restarts has it."""
    sure = NOBODY
    if match.keeper_holding != NOBODY:
        sure = match.players[match.keeper_holding].team
    elif match.game_mode != NORMAL:
        sure = match.restart_team
    for team in (LEFT, RIGHT):
        if sure != NOBODY:
            match.hold[team] = FULL_POSSESSION if sure == team else NO_POSSESSION
            continue
        now = (match.arrival[1 - team] + HOLD_SLACK) / (match.arrival[team] + HOLD_SLACK)
        now = min(max(now, NO_POSSESSION), FULL_POSSESSION)
        match.hold[team] += (now - match.hold[team]) * (1.0 - math.exp(-STEP / POSSESSION_TIME))
    difference = match.hold[LEFT] - match.hold[RIGHT]
    match.lean += (difference - match.lean) / min(match.remembered, TREND_STEPS)


@kernel
def possession_trend(match, team):
    """Return by how much the block of `team` leans forward for who has had the ball in the last seconds: -1 to 1.

    Forward without the ball: measured, in scenes where a defender's slot alone decides where he stands.
    """
    return -forward(team) * match.lean
