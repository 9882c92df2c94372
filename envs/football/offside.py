"""Offside: who is marked when a mate kicks, and the whistle when one of them is next to touch the ball.

Read next: `rules`, which restarts play.
"""

from __future__ import annotations

import math

from envs.football.constants import FREE_KICK, HALF_LENGTH, HALF_WIDTH, LEFT
from envs.football.rules import stop_play
from scenic_lite.jit import kernel

SET_PIECE = 0.5  # m from a line: from a corner or a throw-in nobody is offside


@kernel
def mark_offside(match, kicker):
    """Mark, as bits, the mates of the kicker who are beyond the second-last opponent, the ball and halfway."""
    match.offside_bits = 0
    ball = match.ball
    if not match.offsides or abs(ball.x) > HALF_LENGTH - SET_PIECE or abs(ball.y) > HALF_WIDTH - SET_PIECE:
        return
    team = match.players[kicker].team
    forward = 1.0 if team == LEFT else -1.0
    line = max(second_last(match, 1 - team, forward), forward * ball.x, 0.0)
    for i in range(match.num_players):
        player = match.players[i]
        if i != kicker and player.team == team and forward * player.x > line:
            match.offside_bits |= 1 << i


@kernel
def second_last(match, team, forward):
    """How far forward (towards its own goal) the second-last player of `team` stands, in m."""
    last, second = -math.inf, -math.inf
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team:
            continue
        depth = forward * player.x
        if depth > last:
            last, second = depth, last
        elif depth > second:
            second = depth
    return second


@kernel
def whistled(match, i):
    """Stop play if player i, who is about to touch the ball, was marked; return whether. Any touch lifts the marks."""
    marked = match.offside_bits >> i & 1 == 1
    match.offside_bits = 0
    if marked:
        player = match.players[i]
        stop_play(match, FREE_KICK, 1 - player.team, player.x, player.y)
    return marked
