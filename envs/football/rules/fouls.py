"""Fouls: reports of tackles, and the referee's decisions: advantage, free kick or penalty, cards.

The rules are Google Research Football's. `contacts` determines whether a tackle is a foul and how severe it is, and
calls `report_foul`; `rules` calls the other functions at the end of a step. Read next: `rules.whistle`.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import (
    FREE_KICK,
    HALF_LENGTH,
    LEFT,
    NOBODY,
    NORMAL,
    PENALTY,
    STEP,
)
from regista.envs.football.physics.pitch import in_box_of
from regista.envs.football.physics.possession import lose_ball
from regista.envs.football.rules.whistle import stand_still, stop_play
from regista.kernels.jit import kernel

SEVERE, YELLOW_FROM, RED_FROM = 1.0, 1.4, 2.0  # severities above which a slide is a foul, a yellow card, and a red card
CAUTIONED, SENT_OFF = 1, 2  # values of `cards`
PLAYED_ON, FORGIVEN = 0.6, 3.0  # s of advantage after a trip, at least; s after which the trip is forgotten
LEAVES_AFTER = 6.0  # s from a red card until the player has left the pitch
FAR_BEHIND = 200.0  # m behind the own goal, the position of players who have left
PENALTY_SPOT = HALF_LENGTH - 11.0  # m


@kernel
def report_foul(match, player, victim, severity, slid):
    """Report that `player` fouled `victim`; play goes on until the step ends, or longer for an advantage.

    `severity` is up to about 2: a slide that does not reach the ball has 1, and up to 1 more from behind. A slide with
    at most 1 is no foul. A trip (not `slid`) never gives a card and gets an advantage. A slide takes precedence over a
    trip with advantage; otherwise the first foul counts.
    """
    if match.game_mode != NORMAL or (slid and severity <= SEVERE):
        return
    if match.foul_player != NOBODY and not (slid and match.is_advantage):
        return
    match.foul_player, match.foul_victim = player, victim
    match.foul_severity = severity if slid else 0.0
    match.foul_x, match.foul_y = match.players[victim].x, match.players[victim].y
    match.foul_age, match.is_advantage = 0.0, not slid


@kernel
def judge_foul(match, over):
    """Give the free kick or the penalty for a pending foul, and the card; with `over`, play stops anyway.

    The advantage after a trip outside the box lasts as long as the victim's team keeps the ball.
    """
    if match.foul_player == NOBODY:
        return
    match.foul_age += STEP
    team = match.players[match.foul_victim].team
    in_box = in_box_of(1 - team, match.foul_x, match.foul_y)
    if match.is_advantage and not in_box and not over:
        if match.foul_age > FORGIVEN:
            match.foul_player = NOBODY
            return
        if match.foul_age <= PLAYED_ON or keeps_ball(match, team):
            return
    show_card(match)
    if in_box:
        stop_play(match, PENALTY, team, PENALTY_SPOT if team == LEFT else -PENALTY_SPOT, 0.0)
    else:
        stop_play(match, FREE_KICK, team, match.foul_x, match.foul_y)


@kernel
def keeps_ball(match, team):
    """Return whether `team` still has the ball, judging by the last touch."""
    return match.last_touch != NOBODY and match.players[match.last_touch].team == team


@kernel
def show_card(match):
    """Show the card for the foul; a second yellow card is a red card."""
    player = match.players[match.foul_player]
    if match.foul_severity <= YELLOW_FROM or player.cards == SENT_OFF:
        return
    if match.foul_severity > RED_FROM or player.cards == CAUTIONED:
        player.cards, player.leave_wait = SENT_OFF, LEAVES_AFTER
    else:
        player.cards = CAUTIONED


@kernel
def send_off(match):
    """Let players who have been sent off leave, once their time is up and play is on."""
    for i in range(match.num_players):
        player = match.players[i]
        if player.cards != SENT_OFF or player.has_left:
            continue
        player.leave_wait -= STEP
        if player.leave_wait <= 0.5 * STEP and match.game_mode == NORMAL:
            leave(match, i)


@kernel
def leave(match, i):
    """Take player i off the pitch for good: far behind the own goal, out of all play."""
    player = match.players[i]
    if match.carrier == i or match.kicker == i or match.keeper_holding == i:
        lose_ball(match)
    if match.saver == i:
        match.saver = NOBODY
    if match.receiver == i:
        match.receiver = NOBODY
    if match.last_touch == i:
        match.last_touch, match.reported_owner = NOBODY, NOBODY
    stand_still(player)
    player.has_left = True
    player.down_wait, player.touch_wait = math.inf, math.inf
    player.x, player.y = (-1.0 if player.team == LEFT else 1.0) * FAR_BEHIND, 0.0
