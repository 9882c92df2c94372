"""Who looks after whom: the most dangerous opponents are marked, the one on the ball is hunted by two at most.

As documented of Google Research Football. Read next: `defence`, for what markers and hunters do.
"""

from __future__ import annotations

import math

from envs.football.constants import GK, LEFT, NOBODY, NORMAL, RIGHT
from envs.football.saves import own_goal_x
from envs.football.vectors import apart, length, squared_apart
from scenic_lite.jit import kernel

MARKED = 3  # opponents
MARK_RANGE = 22.0  # m to the place from where an opponent is marked
HUNT_RANGE = 20.0  # m to an opponent on the ball
TIRED_HUNT = 0.4  # share of the range that the tired lack


@kernel
def man_on_ball(match, team):
    """The player of `team` who has the ball or will be first of his team at it, -1 none."""
    i = match.carrier
    if i != NOBODY and match.players[i].team == team:
        return i
    return match.chaser[team]


@kernel
def choose_markers(match):
    """Give each defending team's markers the most dangerous opponents; a team on the ball marks nobody."""
    for i in range(match.num_players):
        match.players[i].mark = NOBODY
    for team in (LEFT, RIGHT):
        if match.favoured != team:
            mark_the_dangerous(match, team)


@kernel
def mark_the_dangerous(match, team):
    """Let the nearest free defenders of `team` mark the most dangerous opponents."""
    taken = 0
    for _ in range(MARKED):
        rival = most_dangerous(match, team, taken)
        if rival == NOBODY:
            return
        taken |= 1 << rival
        marker = nearest_marker(match, team, rival)
        if marker != NOBODY:
            match.players[marker].mark = rival


@kernel
def most_dangerous(match, team, taken):
    """The opponent of `team` closest to its goal, keepers and those in the bits `taken` apart; -1 none."""
    goal_x = own_goal_x(team)
    best, least = NOBODY, math.inf
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == team or rival.role == GK or rival.off or taken >> j & 1 == 1:
            continue
        distance = length(goal_x - rival.x, rival.y)
        if distance < least:
            best, least = j, distance
    return best


@kernel
def nearest_marker(match, team, rival):
    """The free defender of `team` nearest to the place between `rival` and the goal, -1 none within range."""
    marked = match.players[rival]
    to_goal_x = own_goal_x(team) - marked.x
    size = length(to_goal_x, marked.y) + 1e-9
    x, y = marked.x + 2.0 * to_goal_x / size, marked.y - 2.0 * marked.y / size
    best, least = NOBODY, MARK_RANGE * MARK_RANGE
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team or player.role == GK or player.off or player.mark != NOBODY:
            continue
        squared = squared_apart(player, x, y)
        if squared < least:
            best, least = i, squared
    return best


@kernel
def choose_hunters(match):
    """Send the two nearest free defenders within range after an opponent on the ball whom nobody marks."""
    for team in (LEFT, RIGHT):
        match.hunter[team, 0] = NOBODY
        match.hunter[team, 1] = NOBODY
        on_ball = man_on_ball(match, 1 - team)
        if match.favoured == 1 - team and on_ball != NOBODY and match.game_mode == NORMAL:
            send_hunters(match, team, on_ball)


@kernel
def send_hunters(match, team, on_ball):
    """Choose up to two hunters; none if the opponent on the ball is marked."""
    first, second = math.inf, math.inf
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team or player.role == GK:
            continue
        if player.mark == on_ball:
            match.hunter[team, 0], match.hunter[team, 1] = NOBODY, NOBODY
            return
        distance = apart(player, match.players[on_ball])
        if player.mark != NOBODY or distance > hunting_range(player):
            continue
        if distance < first:
            match.hunter[team, 1], second = match.hunter[team, 0], first
            match.hunter[team, 0], first = i, distance
        elif distance < second:
            match.hunter[team, 1], second = i, distance


@kernel
def hunting_range(player):
    """Distance in m within which a player hunts the opponent on the ball."""
    return HUNT_RANGE * player.skill * (1.0 - TIRED_HUNT * player.tired)
