"""Shots and saves: whether the keeper must go, where he meets the ball, and whether he will have it.

The result is drawn when the shot leaves the foot, with odds fitted to saves measured of Google Research Football;
the body then moves to make the draw true. Read next: `skills.contacts`, where hands and ball meet.
"""

from __future__ import annotations

import math

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
from envs.football.physics.vectors import length
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

# logit P(goal) = SAVE_BASE - SAVE_TIME * t + SAVE_WIDE * (0 .. 1 over the gaps), fitted to 434 measured shots
# on target; t: s from the foot to the goal line, gap: m from the keeper to the line of the shot
SAVE_BASE, SAVE_TIME, SAVE_WIDE = 2.9, 9.5, 2.2
GAP_NEAR, GAP_WIDE = 0.7, 0.4  # m: within, he need not dive; this much further, he must
BODY_GAP, BODY_BEATEN = 0.4, 0.35  # m; at most this chance of beating him when shot straight at him
FOOT_GAP, FOOT_CHANCE = 2.0, 0.85  # m; outside his box, where he has his feet only, the chance falls to 0 by then
MEASURED_SKILL, SAVE_SKILL = 0.72, 5.0  # skill of the measured keeper; logit per unit that another lacks
ARM, DIVE_SPEED, DIVE_DELAY = 1.2, 7.5, 0.08  # m, m/s, s: nothing beyond this is ever saved
BEHIND_HIM = 0.08  # s from measured keepers, who stood near their lines, on to the line
FAR_OUT = 0.6  # share of more s than those by which a keeper who has come out has less time
STRIDE = 0.1  # s for which he keeps his velocity
BEFORE_LINE = 0.3  # m before the goal line, where he meets it at the latest
FORESEEN = 300  # frames that a shot is followed ahead
SHOT_SPEED = 9.0  # m/s, slower balls are not shots
GOAL_MARGIN = 1.3  # half widths of the goal within which he goes for the ball
OVER_BAR = 0.3  # m above the bar from where he lets the ball go
READY = 4  # "turning" of a body that already moves: no lag


@kernel
def dive(match, player):
    """Throw the keeper to where he means to meet the shot."""
    dx, dy = match.save_x - player.x, match.save_y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    speed = min(distance / max(match.save_wait, 0.1), DIVE_SPEED)
    share = speed / distance if distance > 0.05 else 0.0
    player.desired_vx, player.desired_vy = share * dx, share * dy


@kernel
def foresee_shot(match, team):
    """After a kick by `team`: find out whether the other keeper must save it, where, and whether he will."""
    match.was_kicked, match.kick_age = True, 0.0
    foresee(match, team)


@kernel
def foresee(match, team):
    """Set the other keeper on a ball that flies at his goal off a player of `team`: draw whether he saves it."""
    match.saver = NOBODY
    goal_x = -own_goal_x(team)
    if ball_speed(match.ball) < SHOT_SPEED or match.ball.vx * goal_x <= 0.0:
        return
    for i in range(match.num_players):
        player = match.players[i]
        if player.team == team or player.role != GK or player.down_wait > 0.0:
            continue
        time, effort, gap = follow_shot(match, player, goal_x)
        if time > 0.0:
            match.saver, match.save_gap = i, gap
            seen = time - FAR_OUT * max(time - match.save_wait - BEHIND_HIM, 0.0)
            match.save_succeeds = uniform(match) < save_chance(player, gap, seen) and effort < DIVE_SPEED
            player.turning = READY
        return


@kernel
def follow_shot(match, player, goal_x):
    """Follow the ball ahead to the goal line, and choose where it costs a keeper least to meet it.

    Returns the s until the ball is in the goal, 0 if it goes wide, over, or never gets there; the m/s that meeting it
    costs; and the m by which its path passes him.
    """
    ball = match.ball
    x, y, z, vx, vy, vz = ball.x, ball.y, ball.z, ball.vx, ball.vy, ball.vz
    spin_x, spin_y, curl = ball.spin_x, ball.spin_y, ball.curl
    here_x, here_y = player.x + STRIDE * player.vx, player.y + STRIDE * player.vy
    least, nearest, gap, time = math.inf, math.inf, math.inf, 0.0
    for _ in range(FORESEEN):
        advance_ball(ball)
        time += DT
        gap = min(gap, length(ball.x - player.x, ball.y - player.y))
        away = length(ball.x - here_x, ball.y - here_y)
        effort = max(away - ARM, 0.0) / max(time - DIVE_DELAY, 0.02)
        outside = abs(ball.x) < HALF_LENGTH - BEFORE_LINE or least == math.inf
        if outside and (effort < least or (effort == least and away < nearest)):
            least, nearest = effort, away
            match.save_x, match.save_y, match.save_wait = ball.x, ball.y, time
        if abs(ball.x) >= HALF_LENGTH:
            break
    inside = abs(ball.y) < GOAL_MARGIN * GOAL_HALF_WIDTH and ball.z < GOAL_HEIGHT + OVER_BAR
    if ball.x * goal_x < HALF_LENGTH * HALF_LENGTH or not inside:
        time = 0.0
    ball.x, ball.y, ball.z, ball.vx, ball.vy, ball.vz = x, y, z, vx, vy, vz
    ball.spin_x, ball.spin_y, ball.curl = spin_x, spin_y, curl
    return time, least, gap


@kernel
def save_chance(player, gap, time):
    """Chance of saving a shot that passes `gap` m away and crosses the line in `time` s."""
    if not in_box_of(player.team, player.x, player.y):
        return FOOT_CHANCE * max(1.0 - (gap / FOOT_GAP) ** 2, 0.0)
    wide = min(max((gap - GAP_NEAR) / GAP_WIDE, 0.0), 1.0)
    logit = SAVE_BASE - SAVE_TIME * time + SAVE_WIDE * wide + SAVE_SKILL * max(MEASURED_SKILL - player.skill, 0.0)
    chance = 1.0 / (1.0 + math.exp(logit))
    return max(chance, 1.0 - BODY_BEATEN) if gap < BODY_GAP else chance
