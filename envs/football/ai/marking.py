"""Marking: the most dangerous opponents are marked; at most two players press the one on the ball.

As documented by Google Research Football. Read next: `ai.defence`, for what markers and pressers do.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.ai.formation import MINDSET
from regista.envs.football.ai.run_speed import EFFORT
from regista.envs.football.constants import GK, HALF_LENGTH, LEFT, NOBODY, NORMAL, RIGHT
from regista.envs.football.physics.pitch import own_goal_x
from regista.envs.football.physics.possession import man_on_ball
from regista.envs.football.physics.vectors import length, squared_apart
from regista.kernels.jit import kernel


class Danger(NamedTuple):
    """Which opponents are most dangerous: those nearest to a point between goal and ball."""

    marked: int = 3  # number of opponents
    goal: float = 0.8  # weight of the goal against the ball
    depth: float = 2.0  # m in front of the goal line
    on_ball: float = 5.8  # m by which the opponent on the ball counts as nearer


class Quality(NamedTuple):
    """How well a player can mark an opponent."""

    lead: float = 0.1  # s by which both runs are extrapolated
    behind: float = 0.5  # m, up to which an opponent counts as not yet past the player
    ahead: float = 2.0  # m goalside of the opponent, the best distance
    far_ahead: float = 60.0  # m from that distance, the worst case
    wide_least: float = 4.0  # m aside, the worst case near the goal
    wide_most: float = 14.0  # m aside, the worst case far from it
    passed: float = 0.6  # factor of the quality if the opponent is past the player
    share: float = 0.8  # weight of quality against nearness


class Press(NamedTuple):
    """Pressing the opponent on the ball."""

    range: float = 10.0  # m to the opponent
    range_defender: float = 10.0  # m more for a defender
    lead: float = 0.1  # s by which the opponent's run is extrapolated, to find the nearest players
    rival_lead: float = 0.12  # s by which the opponent's run is extrapolated, for the distance
    own_lead: float = 0.04  # s by which the presser's own run is extrapolated


# Documented by Google Research Football; families matches and academy of `lab.benchmarks --suite grf`.
DANGER, QUALITY, PRESS = Danger(), Quality(), Press()


@kernel
def choose_markers(match):
    """Assign the most dangerous opponents to both teams' markers, also to those of the team in possession."""
    for i in range(match.num_players):
        match.players[i].marked_opponent = NOBODY
    for team in (LEFT, RIGHT):
        mark_the_dangerous(match, team)


@kernel
def mark_the_dangerous(match, team):
    """Let the best-placed free defenders of `team` mark the most dangerous opponents."""
    taken = 0
    for _ in range(DANGER.marked):
        rival = most_dangerous(match, team, taken)
        if rival == NOBODY:
            return
        taken |= 1 << rival
        marker = best_marker(match, team, rival)
        if marker != NOBODY:
            match.players[marker].marked_opponent = rival


@kernel
def most_dangerous(match, team, taken):
    """Return the opponent of `team` nearest to a point between its goal and the ball, except those with bits in
    `taken`.

    The player on the ball counts as nearer; a keeper counts like any other player. -1: none.
    """
    x = DANGER.goal * (own_goal_x(team) - math.copysign(DANGER.depth, own_goal_x(team)))
    x, y = x + (1.0 - DANGER.goal) * match.ball.x, (1.0 - DANGER.goal) * match.ball.y
    on_ball = man_on_ball(match, 1 - team)
    best, least = NOBODY, math.inf
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == team or rival.has_left or taken >> j & 1 == 1:
            continue
        distance = length(x - rival.x, y - rival.y) - (DANGER.on_ball if j == on_ball else 0.0)
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
    """Return how well a player marks an opponent, 0 to 1: best a little goalside, worse if the opponent is past."""
    x, y = player.x + QUALITY.lead * player.vx, player.y + QUALITY.lead * player.vy
    dx, dy = rival.x + QUALITY.lead * rival.vx - x, rival.y + QUALITY.lead * rival.vy - y
    to_x, to_y = own_goal_x(player.team) - x, -y
    to_goal = length(to_x, to_y) + 1e-9
    ahead, aside = -(dx * to_x + dy * to_y) / to_goal + QUALITY.behind, abs(dx * to_y - dy * to_x) / to_goal
    passed = ahead < 0.0
    off = abs(ahead) if passed else abs(ahead - QUALITY.ahead)
    wide = aside / min(max(to_goal, QUALITY.wide_least), QUALITY.wide_most)
    quality = 1.0 - 0.5 * math.sqrt(min(off / QUALITY.far_ahead, 1.0)) - 0.5 * math.sqrt(min(wide, 1.0))
    quality = max(quality, 0.0) * (QUALITY.passed if passed else 1.0)
    return QUALITY.share * quality + (1.0 - QUALITY.share) * (1.0 - min(length(dx, dy) / (2.0 * HALF_LENGTH), 1.0))


@kernel
def choose_pressers(match):
    """Find both teams' pressers: without the ball, the two players nearest to the opponent on the ball."""
    for team in (LEFT, RIGHT):
        match.hunter[team, 0], match.hunter[team, 1] = NOBODY, NOBODY
        on_ball = man_on_ball(match, 1 - team)
        if on_ball != NOBODY and match.team_in_possession != team:
            find_nearest_two(match, team, match.players[on_ball])


@kernel
def find_nearest_two(match, team, rival):
    """Find and store the two players of `team` nearest to the extrapolated position of an opponent."""
    x, y = rival.x + PRESS.lead * rival.vx, rival.y + PRESS.lead * rival.vy
    first, second = math.inf, math.inf
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team or player.has_left:
            continue
        distance = squared_apart(player, x, y)
        if distance < first:
            match.hunter[team, 1], second = match.hunter[team, 0], first
            match.hunter[team, 0], first = i, distance
        elif distance < second:
            match.hunter[team, 1], second = i, distance


@kernel
def presses(match, i):
    """Return whether player i presses the opponent on the ball: near, free, and one of the two nearest."""
    player = match.players[i]
    team = player.team
    on_ball = man_on_ball(match, 1 - team)
    if on_ball == NOBODY or match.team_in_possession == team or match.game_mode != NORMAL:
        return False
    if player.marked_opponent != NOBODY or (match.hunter[team, 0] != i and match.hunter[team, 1] != i):
        return False
    rival = match.players[on_ball]
    dx = rival.x + PRESS.rival_lead * rival.vx - player.x - PRESS.own_lead * player.vx
    dy = rival.y + PRESS.rival_lead * rival.vy - player.y - PRESS.own_lead * player.vy
    return length(dx, dy) < pressing_range(match, player)


@kernel
def pressing_range(match, player):
    """Return the distance in m within which a player presses: more for defenders, less when tired or unskilled."""
    attacker = MINDSET[match.players[player.post].role]
    fresh = 1.0 - 0.5 * player.tiredness - 0.5 * min(player.mean_speed / EFFORT.sprint, 1.0)
    return (PRESS.range + PRESS.range_defender * (1.0 - attacker)) * fresh * player.skill
