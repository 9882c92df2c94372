"""Who looks after whom: the most dangerous opponents are marked, the one on the ball is pressed by two at most.

As documented of Google Research Football. Read next: `ai.defence`, for what markers and pressers do.
"""

from __future__ import annotations

import math

from envs.football.constants import GK, HALF_LENGTH, LEFT, NOBODY, NORMAL, RIGHT
from envs.football.physics.pitch import own_goal_x
from envs.football.physics.vectors import apart, length
from scenic_lite.kernels.jit import kernel

MARKED = 3  # opponents
DANGER_GOAL, DANGER_DEPTH = 0.8, 2.0  # weight of the goal against the ball; m before its line
ON_BALL = 5.8  # m by which the opponent on the ball counts as nearer
MARK_LEAD = 0.1  # s
BEHIND, MARKED_AHEAD, FAR_AHEAD = 0.5, 2.0, 60.0  # m: who is not passed; the best distance; the worst
WIDE_LEAST, WIDE_MOST = 4.0, 14.0  # m aside, the worst near the goal and far from it
PASSED, QUALITY_SHARE = 0.6, 0.8  # of the quality, for who is passed; against nearness
PRESS_RANGE = 20.0  # m to an opponent on the ball
TIRED_PRESS = 0.4  # share of the range that the tired lack


@kernel
def man_on_ball(match, team):
    """Return the player of `team` who has the ball or will be first of his team at it, -1 none."""
    i = match.carrier
    if i != NOBODY and match.players[i].team == team:
        return i
    return match.chaser[team]


@kernel
def choose_markers(match):
    """Give each defending team's markers the most dangerous opponents; a team on the ball marks nobody."""
    for i in range(match.num_players):
        match.players[i].marked_opponent = NOBODY
    for team in (LEFT, RIGHT):
        if match.team_in_possession != team:
            mark_the_dangerous(match, team)


@kernel
def mark_the_dangerous(match, team):
    """Let the free defenders of `team` who are best placed for it mark the most dangerous opponents."""
    taken = 0
    for _ in range(MARKED):
        rival = most_dangerous(match, team, taken)
        if rival == NOBODY:
            return
        taken |= 1 << rival
        marker = best_marker(match, team, rival)
        if marker != NOBODY:
            match.players[marker].marked_opponent = rival


@kernel
def most_dangerous(match, team, taken):
    """Return the opponent of `team` nearest to a place between its goal and the ball, keepers and the bits `taken`
    apart.

    Who is on the ball counts as nearer than he is. -1: none.
    """
    x = DANGER_GOAL * (own_goal_x(team) - math.copysign(DANGER_DEPTH, own_goal_x(team)))
    x, y = x + (1.0 - DANGER_GOAL) * match.ball.x, (1.0 - DANGER_GOAL) * match.ball.y
    on_ball = man_on_ball(match, 1 - team)
    best, least = NOBODY, math.inf
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == team or rival.role == GK or rival.has_left or taken >> j & 1 == 1:
            continue
        distance = length(x - rival.x, y - rival.y) - (ON_BALL if j == on_ball else 0.0)
        if distance < least:
            best, least = j, distance
    return best


@kernel
def best_marker(match, team, rival):
    """Return the free defender of `team` who marks `rival` best, -1 none."""
    best, most = NOBODY, -1.0
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team or player.role == GK or player.has_left or player.marked_opponent != NOBODY:
            continue
        quality = marking_quality(player, match.players[rival])
        if quality > most:
            best, most = i, quality
    return best


@kernel
def marking_quality(player, rival):
    """Return how well a player marks an opponent, 0 to 1: best from a little way in front of him, seen from the goal.

    Who is past him he marks badly.
    """
    x, y = player.x + MARK_LEAD * player.vx, player.y + MARK_LEAD * player.vy
    dx, dy = rival.x + MARK_LEAD * rival.vx - x, rival.y + MARK_LEAD * rival.vy - y
    to_x, to_y = own_goal_x(player.team) - x, -y
    to_goal = length(to_x, to_y) + 1e-9
    ahead, aside = -(dx * to_x + dy * to_y) / to_goal + BEHIND, abs(dx * to_y - dy * to_x) / to_goal
    passed = ahead < 0.0
    off = abs(ahead) if passed else abs(ahead - MARKED_AHEAD)
    wide = aside / min(max(to_goal, WIDE_LEAST), WIDE_MOST)
    quality = 1.0 - 0.5 * math.sqrt(min(off / FAR_AHEAD, 1.0)) - 0.5 * math.sqrt(min(wide, 1.0))
    quality = max(quality, 0.0) * (PASSED if passed else 1.0)
    return QUALITY_SHARE * quality + (1.0 - QUALITY_SHARE) * (1.0 - min(length(dx, dy) / (2.0 * HALF_LENGTH), 1.0))


@kernel
def choose_pressers(match):
    """Send the two nearest free defenders within range after an opponent on the ball whom nobody marks."""
    for team in (LEFT, RIGHT):
        match.presser[team, 0] = NOBODY
        match.presser[team, 1] = NOBODY
        on_ball = man_on_ball(match, 1 - team)
        if match.team_in_possession == 1 - team and on_ball != NOBODY and match.game_mode == NORMAL:
            send_pressers(match, team, on_ball)


@kernel
def send_pressers(match, team, on_ball):
    """Choose up to two pressers; none if the opponent on the ball is marked."""
    first, second = math.inf, math.inf
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team or player.role == GK:
            continue
        if player.marked_opponent == on_ball:
            match.presser[team, 0], match.presser[team, 1] = NOBODY, NOBODY
            return
        distance = apart(player, match.players[on_ball])
        if player.marked_opponent != NOBODY or distance > pressing_range(player):
            continue
        if distance < first:
            match.presser[team, 1], second = match.presser[team, 0], first
            match.presser[team, 0], first = i, distance
        elif distance < second:
            match.presser[team, 1], second = i, distance


@kernel
def pressing_range(player):
    """Return the distance in m within which a player presses the opponent on the ball."""
    return PRESS_RANGE * player.skill * (1.0 - TIRED_PRESS * player.tiredness)
