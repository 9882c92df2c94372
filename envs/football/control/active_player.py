"""The player that a single agent of Google Research Football controls: how control changes, and the first step.

Each team has a *designated* player, who should win the ball. The designated player becomes active as soon as only that
team owns the ball, or if it needs a third of the active player's time to the ball. Keepers are excepted. A pass makes
its receiver both designated and active. Sticky actions move along with the agent; a kick or a slide stays with its
player. An episode begins with a player who may be far from the ball (the keeper, in small teams), and these rules apply
within the first step. So a kick or slide of the first step is usually lost.
Read next: `control.agents`, the other control modes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import ACTIVE, BUILTIN_AI, GK, IDLE, NOBODY, STEP
from regista.envs.football.control.actions import is_button
from regista.envs.football.physics.possession import is_too_far, look_ahead, meeting_time, owns, time_if_before
from regista.kernels.jit import kernel


class Designation(NamedTuple):
    """When another player becomes the designated one: if it reaches the ball clearly sooner."""

    patience: float = 0.5  # s added to both times
    rating: float = 0.8  # ratio of the times, below which the designation changes
    has_ball: float = 0.5  # factor of the ratio for the ball's owner
    is_active: float = 0.8  # factor of the ratio for the agent's player
    ahead: float = 0.1  # s; if the present player leads all opponents by more, a change (except to the agent's player)
    ahead_more: float = 0.2  # is less urgent: this is added to the rating,
    ahead_times: float = 1.2  # and the sum is multiplied by this


# Documented by Google Research Football, and checked against the first steps of its episodes.
DESIGNATION = Designation()
SOONER = 3.0  # ratio of the times to the ball of the active and the designated player at which control changes
FIRST_PLAYERS = (0, 0, 0, 0, 0, 0, 5, 6)  # index of the active player when a match begins, by the size of the team


@kernel
def settle_first_step(match):
    """Assign players to `active` agents before the first step is played; only their sticky actions move along."""
    first = 0
    for team in range(2):
        if match.control[team] == ACTIVE:
            old = match.agents[first]
            choose_active(match, team, first)
            new = match.agents[first]
            if new != old:
                action = match.players[old].action
                match.players[new].action = IDLE if is_button(action) else action
                match.players[old].action = BUILTIN_AI
        first += match.num_agents[team]


@kernel
def choose_active(match, team, agent):
    """Assign a team's only agent the same player as Google Research Football; sticky actions move along."""
    old = match.agents[agent]
    new = active_player(match, team, old)
    if new in (old, NOBODY):
        return
    match.agents[agent] = new
    new_player = match.players[new]
    new_player.agent = agent
    if old != NOBODY:
        old_player = match.players[old]
        old_player.agent = NOBODY
        new_player.direction, new_player.sprint, new_player.dribble = (
            old_player.direction,
            old_player.sprint,
            old_player.dribble,
        )


@kernel
def active_player(match, team, old):
    """Return the active player: the taker of a restart, else the receiver of a new pass, else by designation."""
    if match.taker != NOBODY and match.players[match.taker].team == team:
        match.designated[team] = match.taker
        return match.taker
    if is_passed_to(match, team):
        match.designated[team] = match.receiver
        return match.receiver
    designate(match, team, old)
    new = match.designated[team]
    if old == NOBODY or match.players[old].has_left or new == NOBODY:
        return new
    player = match.players[new]
    if new == old or player.role == GK:
        return old
    if owns(match.ball, player) and not opponents_own(match, team):
        return new
    ahead = look_ahead(match.ball)
    return new if SOONER * time_to_ball(match, player, ahead) < time_to_ball(match, match.players[old], ahead) else old


@kernel
def is_passed_to(match, team):
    """Return whether a pass to a player of the team has left a teammate's foot in this step."""
    if match.receiver == NOBODY or match.last_touch in (NOBODY, match.receiver) or match.kick_age > 1.5 * STEP:
        return False
    return match.players[match.receiver].team == team and match.players[match.last_touch].team == team


@kernel
def designate(match, team, active):
    """Choose a team's designated player: the first one at the ball, if clearly sooner than the current one."""
    ahead, present = look_ahead(match.ball), match.designated[team]
    is_there = present != NOBODY and not match.players[present].has_left
    best, soonest = first_of_team(match, team, present if is_there else NOBODY, ahead)
    if not is_there:
        match.designated[team] = best
    elif best != present:
        time = time_to_ball(match, match.players[present], ahead)
        rating = (soonest + DESIGNATION.patience) / (time + DESIGNATION.patience)
        rating *= designation_factor(match, best, active) / designation_factor(match, present, active)
        if best != active:
            _, opponents = first_of_team(match, 1 - team, match.chaser[1 - team], ahead)
            if time < opponents - DESIGNATION.ahead:
                rating = DESIGNATION.ahead_times * (rating + DESIGNATION.ahead_more)
        if rating < DESIGNATION.rating:
            match.designated[team] = best


@kernel
def first_of_team(match, team, likely, ahead):
    """Return the player of `team` who reaches the ball first (-1: none), and the time in s.

    The player `likely` (-1: none) is tried first, which rules out most of the others quickly.
    """
    best, soonest = likely, math.inf
    if likely != NOBODY:
        soonest = time_to_ball(match, match.players[likely], ahead)
    for i in range(match.num_players):
        player = match.players[i]
        if i == likely or player.team != team or player.has_left:
            continue
        if is_too_far(match.ball, ahead, player, soonest):
            continue
        time = time_if_before(match.ball, ahead, player, soonest - player.down_wait) + player.down_wait
        if time < soonest or (time == soonest and player.order < match.players[best].order):
            best, soonest = i, time
    return best, soonest


@kernel
def designation_factor(match, i, active):
    """Return the factor of player i's time for designation: the smaller, the more suitable."""
    has_ball = DESIGNATION.has_ball if owns(match.ball, match.players[i]) else 1.0
    return has_ball * (DESIGNATION.is_active if i == active else 1.0)


@kernel
def opponents_own(match, team):
    """Return whether any opponent of the team counts as the owner of the ball."""
    count = 0
    for i in range(match.num_players):
        count += match.players[i].team != team and owns(match.ball, match.players[i])
    return count > 0


@kernel
def time_to_ball(match, player, ahead):
    """Return the time in s after which a player can be at the ball, including getting up."""
    return meeting_time(match.ball, ahead, player) + player.down_wait
