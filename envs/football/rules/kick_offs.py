"""Kick-offs after a goal and at half time: all players return to their start positions, and play continues at once.

As in Google Research Football, the kick-off mode is never reported. Read next: `rules.referee`.
"""

from __future__ import annotations

from regista.envs.football.constants import NOBODY
from regista.envs.football.rules.whistle import move_to, put_ball
from regista.kernels.jit import kernel


@kernel
def kick_off_again(match, team, x, y):
    """Let `team` kick off with the ball at (x, y).

    If the other team began the match with the ball and the teams have equal sizes, each team takes the other's start
    positions, rotated by 180°. So the ball is in front of the team that kicks off.
    """
    put_ball(match, x, y)
    swapped = swaps(match, team)
    for i in range(match.num_players):
        player = match.players[i]
        if not swapped:
            move_to(match, i, player.start_x, player.start_y)
            continue
        j = counterpart(match, i)
        move_to(match, i, -match.players[j].start_x, -match.players[j].start_y)
    match.last_touch = NOBODY
    match.foul_player = NOBODY
    match.offside_bits = 0
    match.line_wait = 0.0


@kernel
def second_half(match):
    """Begin the second half: the team that did not begin the match kicks off; teams do not change sides."""
    match.half = 1
    team = 1 - match.starter
    turn = -1.0 if swaps(match, team) else 1.0
    kick_off_again(match, team, turn * match.ball_start_x, turn * match.ball_start_y)


@kernel
def swaps(match, team):
    """Return whether the teams take each other's start positions when `team` kicks off."""
    left = 0
    for i in range(match.num_players):
        left += match.players[i].team == 0
    return team != match.starter and 2 * left == match.num_players


@kernel
def counterpart(match, i):
    """Return the opponent with player i's shirt number."""
    player = match.players[i]
    for j in range(match.num_players):
        if match.players[j].team != player.team and match.players[j].shirt == player.shirt:
            return j
    return i
