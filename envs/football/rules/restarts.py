"""Restarts: players are placed, and a taker is chosen, who then plays the ball (see `ai.set_pieces`).

Read next: `rules.placing`, the positions of the others.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import FREE_KICK, NOBODY, PENALTY, THROW_IN
from regista.envs.football.physics.pitch import forward
from regista.envs.football.physics.vectors import apart, toward
from regista.envs.football.rules.placing import EVEN, place_players
from regista.envs.football.rules.whistle import move_to
from regista.kernels.jit import kernel

THROWER_OUT, RUN_UP, RUN_UP_FREE, RUN_UP_PENALTY = 0.3, 2.3, 2.3, 3.0  # m behind the ball, start of the taker
HELD_AT = 1.5  # m, height of the ball in the hands of the thrower


@kernel
def set_up(match):
    """Set up the pending restart and choose its taker; if the team has no players, the other team takes it."""
    if nearest_of(match, match.restart_team) == NOBODY:
        match.restart_team = 1 - match.restart_team
    place_players(match)
    taker = nearest_of(match, match.restart_team)
    match.taker, match.restart_wait, match.restart_kick = taker, 0, NOBODY
    if taker == NOBODY:
        return
    ball = match.ball
    dx, dy, behind = run_up(match, match.players[taker].team)
    move_to(match, taker, ball.x + behind * dx, ball.y + behind * dy)
    match.last_touch = taker
    if match.game_mode == THROW_IN:
        ball.z = HELD_AT


@kernel
def run_up(match, team):
    """Return the start of the taker: a direction from the ball, and the distance along it in m."""
    ball = match.ball
    backward = -forward(team)
    if match.game_mode == FREE_KICK:
        return backward, 0.0, RUN_UP_FREE
    if match.game_mode == PENALTY:
        return backward, 0.0, RUN_UP_PENALTY
    dx, dy = toward(ball.x, ball.y)
    return dx, dy, THROWER_OUT if match.game_mode == THROW_IN else RUN_UP


@kernel
def nearest_of(match, team):
    """Return the player of `team` nearest to the ball, -1 if it has none on the pitch."""
    nearest, best = math.inf, NOBODY
    for i in range(match.num_players):
        player = match.players[i]
        distance = apart(match.ball, player)
        if player.team == team and not player.has_left and distance < nearest - EVEN:
            nearest, best = distance, i
    return best
