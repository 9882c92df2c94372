"""The player whom a single agent of Google Research Football has: its laws of handing him on, and the first step.

Each team has *designated* a player to win the ball; he is the active one as soon as he has it alone, or is three times
sooner at it than the active one, keepers apart. A pass makes its receiver both. The sticky keys go with the agent; a
kick or a slide stays with whom it was pressed for. An episode begins with a player who need not be near the ball (the
keeper, in small teams), and the laws apply within its first step: so its kick or slide is usually lost.
Read next: `control.agents`, the other ways to get a player.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import ACTIVE, BUILTIN_AI, GK, IDLE, NOBODY, STEP
from regista.envs.football.control.actions import is_button
from regista.envs.football.physics.possession import is_too_far, look_ahead, meeting_time, owns, time_if_before
from regista.kernels.jit import kernel


class Designation(NamedTuple):
    """When another player of the team than the designated one is designated: clearly sooner at the ball."""

    patience: float = 0.5  # s that both times are longer than they are
    rating: float = 0.8  # of his time by that of the designated one, below which he is
    has_ball: float = 0.5  # what having the ball makes of that
    is_active: float = 0.8  # what being moved by the agent makes of it
    ahead: float = 0.1  # s before the first opponent: then there is less need, unless the agent moves him
    ahead_more: float = 0.2  # added to the rating then,
    ahead_times: float = 1.2  # which is also multiplied by this


# Documented of Google Research Football, and checked by its own episodes' first steps.
DESIGNATION = Designation()
SOONER = 3.0  # times as soon at the ball as the active player: the designated one becomes it
FIRST_PLAYERS = (0, 0, 0, 0, 0, 0, 5, 6)  # index of who is active when a match begins, by the size of the team


@kernel
def settle_first_step(match):
    """Let agents of this kind get their players before an episode's first step is played, and its sticky keys alone."""
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
    """Give the only agent of a team the player whom Google Research Football would; its sticky keys go with it."""
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
    """Return who takes the restart, or for whom a mate's pass has just been meant, else whom designation makes it."""
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
    """Return whether a pass to a player of the team has left a mate's foot in this step."""
    if match.receiver == NOBODY or match.last_touch in (NOBODY, match.receiver) or match.kick_age > 1.5 * STEP:
        return False
    return match.players[match.receiver].team == team and match.players[match.last_touch].team == team


@kernel
def designate(match, team, active):
    """Choose whom the team designates: who is soonest at the ball, but only if clearly sooner than the present one."""
    ahead, present = look_ahead(match.ball), match.designated[team]
    is_there = present != NOBODY and not match.players[present].has_left
    best, soonest = first_of_team(match, team, present if is_there else NOBODY, ahead)
    if not is_there:
        match.designated[team] = best
    elif best != present:
        time = time_to_ball(match, match.players[present], ahead)
        rating = (soonest + DESIGNATION.patience) / (time + DESIGNATION.patience)
        rating *= standing(match, best, active) / standing(match, present, active)
        if best != active:
            _, opponents = first_of_team(match, 1 - team, match.chaser[1 - team], ahead)
            if time < opponents - DESIGNATION.ahead:
                rating = DESIGNATION.ahead_times * (rating + DESIGNATION.ahead_more)
        if rating < DESIGNATION.rating:
            match.designated[team] = best


@kernel
def first_of_team(match, team, likely, ahead):
    """Return the player of `team` who is soonest at the ball, -1 none, and in how many s.

    The `likely` one, -1 for none, is tried first: then most of the others are seen to be too far away.
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
def standing(match, i, active):
    """Return what speaks for player i as the designated one: the less the more."""
    has_ball = DESIGNATION.has_ball if owns(match.ball, match.players[i]) else 1.0
    return has_ball * (DESIGNATION.is_active if i == active else 1.0)


@kernel
def opponents_own(match, team):
    """Return whether an opponent of the team could be said to own the ball."""
    count = 0
    for i in range(match.num_players):
        count += match.players[i].team != team and owns(match.ball, match.players[i])
    return count > 0


@kernel
def time_to_ball(match, player, ahead):
    """Return the seconds in which a player can be at the ball, once he is on his feet."""
    return meeting_time(match.ball, ahead, player) + player.down_wait
