"""Shots and saves: whether the keeper must go, where he meets the ball, and whether he will have it.

The result is drawn when the shot leaves the foot, with odds fitted to saves measured of Google Research Football;
the body then moves to make the draw true. Read next: `skills.contacts`, where hands and ball meet.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from envs.football.constants import (
    DT,
    GK,
    GOAL_HALF_WIDTH,
    GOAL_HEIGHT,
    HALF_LENGTH,
    NOBODY,
)
from envs.football.physics.ball import advance_ball
from envs.football.physics.pitch import in_box_of, own_goal_x
from envs.football.physics.possession import ball_speed
from envs.football.physics.running import READY
from envs.football.physics.vectors import length, squared_apart
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform


class SaveOdds(NamedTuple):
    """Whether the keeper has a shot: logit P(goal) = base - time * t + wide * (0 .. 1 over the gaps).

    t: s from the foot to the goal line, gap: m from the keeper to the line of the shot. Fitted to 434 measured shots on
    target: `regista benchmark --suite grf`, family keeper.
    """

    base: float = 2.9  # logit
    time: float = 9.5  # logit per s
    wide: float = 2.2  # logit
    gap_near: float = 0.7  # m: within, he need not dive
    gap_wide: float = 0.4  # m further: he must
    body_gap: float = 0.4  # m: shot straight at him
    body_beaten: float = 0.35  # at most this chance of beating him then
    sudden: float = 0.13  # s to him: sooner, he need not do anything to be hit
    blocked_gap: float = 0.9  # m, by a shot that passes him at less than that,
    blocked: float = 0.9  # as often
    foot_gap: float = 2.0  # m; outside his box, where he has his feet only, the chance falls to 0 by then
    foot_chance: float = 0.85  # straight at his feet
    measured_skill: float = 0.72  # `skill` of the measured keeper
    skill: float = 5.0  # logit per unit that another lacks


class Dive(NamedTuple):
    """How a keeper gets to a shot; the same family."""

    arm: float = 1.2  # m
    speed: float = 7.5  # m/s: nothing that takes more is ever saved
    delay: float = 0.08  # s
    behind_him: float = 0.08  # s from measured keepers, who stood near their lines, on to the line
    far_out: float = 0.6  # share of more s than those by which a keeper who has come out has less time
    stride: float = 0.1  # s for which he keeps his velocity
    before_line: float = 0.3  # m before the goal line, where he meets it at the latest
    shot_speed: float = 9.0  # m/s, slower balls are not shots
    goal_margin: float = 1.3  # half widths of the goal within which he goes for the ball
    over_bar: float = 0.3  # m above the bar from where he lets the ball go


SAVE, DIVE = SaveOdds(), Dive()
FORESEEN = 300  # frames that a shot is followed ahead


@kernel
def dive(match, player):
    """Throw the keeper to where he means to meet the shot."""
    dx, dy = match.save_x - player.x, match.save_y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    speed = min(distance / max(match.save_wait, 0.1), DIVE.speed * match.engine.keeper_speed)
    share = speed / distance if distance > 0.05 else 0.0
    player.desired_vx, player.desired_vy = share * dx, share * dy


@kernel
def foresee_shot(match, team):
    """Find out, after a kick by `team`, whether the other keeper must save it, where, and whether he will."""
    match.was_kicked, match.kick_age = True, 0.0
    foresee(match, team)


@kernel
def foresee(match, team):
    """Set the other keeper on a ball that flies at his goal off a player of `team`: draw whether he saves it."""
    match.saver = NOBODY
    goal_x = -own_goal_x(team)
    if ball_speed(match.ball) < DIVE.shot_speed or match.ball.vx * goal_x <= 0.0:
        return
    for i in range(match.num_players):
        player = match.players[i]
        if player.team == team or player.role != GK or player.down_wait > 0.0:
            continue
        time, effort, gap = follow_shot(match, player, goal_x)
        if time > 0.0:
            match.saver, match.save_gap = i, gap
            seen = time - DIVE.far_out * max(time - match.save_wait - DIVE.behind_him, 0.0)
            chance = save_chance(player, gap / match.engine.keeper_reach, seen)
            within = effort < DIVE.speed * match.engine.keeper_speed
            if strikes(match.ball, player, gap):
                chance, within = max(chance, SAVE.blocked), True
            match.save_succeeds = uniform(match) < chance and within
            player.turning = READY
        return


@kernel
def strikes(ball, player, gap):
    """Return whether a shot that passes a keeper `gap` m away hits him before he can do anything."""
    speed = ball_speed(ball)
    to_x, to_y = player.x - ball.x, player.y - ball.y
    near = to_x * to_x + to_y * to_y < (SAVE.sudden * speed) ** 2
    return near and gap < SAVE.blocked_gap and to_x * ball.vx + to_y * ball.vy > 0.0


@kernel
def follow_shot(match, player, goal_x):
    """Follow the ball ahead to the goal line, and choose where it costs a keeper least to meet it.

    Returns the s until the ball is in the goal, 0 if it goes wide, over, or never gets there; the m/s that meeting it
    costs; and the m by which its path passes him.
    """
    ball = match.ball
    x, y, z, vx, vy, vz = ball.x, ball.y, ball.z, ball.vx, ball.vy, ball.vz
    spin_x, spin_y, curl = ball.spin_x, ball.spin_y, ball.curl
    here_x, here_y = player.x + DIVE.stride * player.vx, player.y + DIVE.stride * player.vy
    least, nearest, gap, time = math.inf, math.inf, math.inf, 0.0  # `gap` squared
    for _ in range(FORESEEN):
        advance_ball(ball)
        time += DT
        gap = min(gap, squared_apart(player, ball.x, ball.y))
        away = length(ball.x - here_x, ball.y - here_y)
        effort = max(away - DIVE.arm * match.engine.keeper_reach, 0.0) / max(time - DIVE.delay, 0.02)
        outside = abs(ball.x) < HALF_LENGTH - DIVE.before_line or least == math.inf
        if outside and (effort < least or (effort == least and away < nearest)):
            least, nearest = effort, away
            match.save_x, match.save_y, match.save_wait = ball.x, ball.y, time
        if abs(ball.x) >= HALF_LENGTH:
            break
    inside = abs(ball.y) < DIVE.goal_margin * GOAL_HALF_WIDTH and ball.z < GOAL_HEIGHT + DIVE.over_bar
    if ball.x * goal_x < HALF_LENGTH * HALF_LENGTH or not inside:
        time = 0.0
    ball.x, ball.y, ball.z, ball.vx, ball.vy, ball.vz = x, y, z, vx, vy, vz
    ball.spin_x, ball.spin_y, ball.curl = spin_x, spin_y, curl
    return time, least, math.sqrt(gap)


@kernel
def save_chance(player, gap, time):
    """Return the chance of saving a shot that passes `gap` m away and crosses the line in `time` s."""
    if not in_box_of(player.team, player.x, player.y):
        return SAVE.foot_chance * max(1.0 - (gap / SAVE.foot_gap) ** 2, 0.0)
    wide = min(max((gap - SAVE.gap_near) / SAVE.gap_wide, 0.0), 1.0)
    logit = SAVE.base - SAVE.time * time + SAVE.wide * wide + SAVE.skill * max(SAVE.measured_skill - player.skill, 0.0)
    chance = 1.0 / (1.0 + math.exp(logit))
    return max(chance, 1.0 - SAVE.body_beaten) if gap < SAVE.body_gap else chance
