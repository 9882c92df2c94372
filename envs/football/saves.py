"""Shots and saves: whether the keeper must go, where he meets the ball, and whether he will have it.

The result is drawn when the shot leaves the foot, with odds fitted to saves measured of Google Research Football;
the body then moves to make the draw true. Read next: `contacts`, where hands and ball meet.
"""

from __future__ import annotations

import math

from envs.football.ball import flight_time
from envs.football.constants import (
    BOX_DEPTH,
    BOX_HALF_WIDTH,
    GK,
    GOAL_HALF_WIDTH,
    GOAL_HEIGHT,
    HALF_LENGTH,
    LEFT,
    NOBODY,
)
from envs.football.possession import ball_speed
from envs.football.vectors import length
from scenic_lite.jit import kernel
from scenic_lite.stream import uniform

# logit P(goal) = base − slope × time + wide × (0 .. 1 over the gaps), fitted to 433 measured shots on target
SAVE_BASE, SAVE_TIME, SAVE_WIDE = 2.6, 9.5, 2.4
GAP_NEAR, GAP_WIDE = 1.0, 0.5  # m from the shot's line: within, he hardly moves; this much further, he must dive
BODY_GAP, BODY_BEATEN = 0.45, 0.25  # m; at most this chance of beating him when shot straight at him
FOOT_GAP, FOOT_CHANCE = 1.2, 0.6  # m; outside his box he has his feet only
MEASURED_SKILL, SAVE_SKILL = 0.72, 2.0  # skill of the measured keeper; logit per unit of skill
DIVE_REACH, DIVE_COVER, DIVE_DELAY = 1.2, 4.5, 0.1  # m, m/s, s: nothing beyond this is ever saved
DIVE_SPEED = 7.5  # m/s
STRIDE = 0.15  # s for which he keeps his velocity
MEETING_PLACES = 4
SHOT_SPEED = 9.0  # m/s, slower balls are not shots
GOAL_MARGIN = 1.1  # goal widths within which he goes for the ball
READY = 4  # "turning" of a body that already moves: no lag


@kernel
def own_goal_x(team):
    """x of the goal line that a team defends."""
    return -HALF_LENGTH if team == LEFT else HALF_LENGTH


@kernel
def in_own_box(player):
    """Tell whether a player stands in his own penalty box, where a keeper may use his hands."""
    return abs(own_goal_x(player.team) - player.x) < BOX_DEPTH and abs(player.y) < BOX_HALF_WIDTH


@kernel
def dive(match, player):
    """Throw the keeper to where he means to meet the shot."""
    dx, dy = match.save_x - player.x, match.save_y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    speed = min(distance / max(match.save_wait, 0.1), DIVE_SPEED)
    share = speed / distance if distance > 0.05 else 0.0
    player.want_x, player.want_y = share * dx, share * dy


@kernel
def foresee_shot(match, team):
    """After a kick by `team`: find out whether the other keeper must save it, where, and whether he will."""
    match.saver = NOBODY
    ball = match.ball
    goal_x = -own_goal_x(team)
    speed = ball_speed(ball)
    if speed < SHOT_SPEED or ball.vx * goal_x <= 0.0:
        return
    line_y = ball.y + (goal_x - ball.x) / ball.vx * ball.vy
    if abs(line_y) > GOAL_MARGIN * 2.0 * GOAL_HALF_WIDTH or flight_time(speed, abs(goal_x - ball.x)) > 3.0:
        return
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team and player.role == GK and player.down <= 0.0:
            plan_save(match, i, goal_x, line_y, speed)
            return


@kernel
def plan_save(match, i, goal_x, line_y, speed):
    """Choose keeper i's best chance between the shot's closest point and the goal line, and draw the result."""
    player, ball = match.players[i], match.ball
    ux, uy = ball.vx / speed, ball.vy / speed
    here_x, here_y = player.x + STRIDE * player.vx, player.y + STRIDE * player.vy
    along = (here_x - ball.x) * ux + (here_y - ball.y) * uy
    to_line = length(goal_x - ball.x, line_y - ball.y)
    along = to_line if along < -0.3 else min(max(along, 0.3), to_line)
    match.saver = i
    best = -1.0
    for k in range(MEETING_PLACES):
        distance = along + k / (MEETING_PLACES - 1) * (to_line - along)
        x, y = ball.x + distance * ux, ball.y + distance * uy
        gap, time = length(x - here_x, y - here_y), flight_time(speed, distance)
        chance = save_chance(player, gap, time)
        if chance > best:
            best = chance
            match.save_x, match.save_y, match.save_gap, match.save_wait = x, y, gap, time
    match.save_succeeds = uniform(match) < best and height_at(ball, match.save_wait) < GOAL_HEIGHT + 0.2
    player.turning = READY


@kernel
def save_chance(player, gap, time):
    """Chance of saving a shot that passes `gap` m away in `time` s."""
    if gap > DIVE_REACH + DIVE_COVER * max(time - DIVE_DELAY, 0.0):
        return 0.0
    if not in_own_box(player):
        return 1.0 - BODY_BEATEN if gap < BODY_GAP else (FOOT_CHANCE if gap < FOOT_GAP else 0.0)
    wide = min(max((gap - GAP_NEAR) / GAP_WIDE, 0.0), 1.0)
    logit = SAVE_BASE - SAVE_TIME * time + SAVE_WIDE * wide + SAVE_SKILL * (MEASURED_SKILL - player.skill)
    chance = 1.0 / (1.0 + math.exp(logit))
    return max(chance, 1.0 - BODY_BEATEN) if gap < BODY_GAP else chance


@kernel
def height_at(ball, time):
    """Height in m of a ball in free flight after this time."""
    return ball.z + ball.vz * time - 4.9 * time * time
