"""Offside: the players who are offside at a touch, and the whistle if one of them is the next to touch the ball.

Read next: `rules.whistle`.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import FREE_KICK
from regista.envs.football.physics.pitch import forward
from regista.envs.football.rules.whistle import stop_play
from regista.kernels.jit import kernel


@kernel
def mark_offside(match, toucher):
    """Store the bits of the toucher's teammates who are beyond the second-last opponent, the ball and the halfway line.

    As in Google Research Football, there is no offside against a team with fewer than two players.
    """
    match.offside_bits = 0
    if not match.offsides:
        return
    team = match.players[toucher].team
    ahead = forward(team)
    second = second_last(match, 1 - team, ahead)
    if second == -math.inf:
        return
    line = max(second, ahead * match.ball.x, 0.0)
    for i in range(match.num_players):
        player = match.players[i]
        if i != toucher and player.team == team and not player.has_left and ahead * player.x > line:
            match.offside_bits |= 1 << i


@kernel
def second_last(match, team, ahead):
    """Return how far forward (towards its own goal) the second-last player of `team` is, in m; -inf without one."""
    last, second = -math.inf, -math.inf
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team or player.has_left:
            continue
        depth = ahead * player.x
        if depth > last:
            last, second = depth, last
        elif depth > second:
            second = depth
    return second


@kernel
def whistled(match, i):
    """Stop play if player i, who is about to touch the ball, was marked; return whether play stopped.

    If play goes on, the touch marks the teammates again.
    """
    if match.offside_bits >> i & 1 == 1:
        player = match.players[i]
        stop_play(match, FREE_KICK, 1 - player.team, player.x, player.y)
        return True
    mark_offside(match, i)
    return False
