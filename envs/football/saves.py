"""Shots and saves: whether the keeper must go, where he meets the ball, and whether he will have it.

The result is drawn when the shot leaves the foot, with odds fitted to saves measured of Google Research Football;
the body then moves to make the draw true. Read next: `contacts`, where hands and ball meet.
"""

from __future__ import annotations

import math

from envs.football.ball import crossing, flight_time
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

# logit P(goal) = SAVE_BASE - SAVE_TIME * t + SAVE_WIDE * (0 .. 1 over the gaps), fitted to 434 measured shots
# on target; t: s from the foot to the goal line, gap: m from the keeper to the line of the shot
SAVE_BASE, SAVE_TIME, SAVE_WIDE = 2.9, 9.5, 2.6
GAP_NEAR, GAP_WIDE = 0.7, 0.4  # m: within, he need not dive; this much further, he must
BODY_GAP, BODY_BEATEN = 0.4, 0.35  # m; at most this chance of beating him when shot straight at him
FOOT_GAP, FOOT_CHANCE = 1.2, 0.72  # m; chance outside his box, where he has his feet only
MEASURED_SKILL, SAVE_SKILL = 0.72, 2.5  # skill of the measured keeper; logit per unit of skill
ARM, DIVE_SPEED, DIVE_DELAY = 1.2, 7.5, 0.08  # m, m/s, s: nothing beyond this is ever saved
STRIDE = 0.1  # s for which he keeps his velocity
MEETING_PLACES = 4
SHOT_SPEED = 9.0  # m/s, slower balls are not shots
GOAL_MARGIN = 1.3  # half widths of the goal within which he goes for the ball
OVER_BAR = 0.3  # m above the bar from where he lets the ball go
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
    match.kicked, match.kick_age = True, 0.0
    foresee(match, team)


@kernel
def foresee(match, team):
    """Set the other keeper on a ball that flies at his goal off a player of `team`."""
    match.saver = NOBODY
    ball = match.ball
    goal_x = -own_goal_x(team)
    speed = ball_speed(ball)
    if speed < SHOT_SPEED or ball.vx * goal_x <= 0.0:
        return
    line_y = crossing(ball, goal_x)
    if abs(line_y) > GOAL_MARGIN * GOAL_HALF_WIDTH:
        return
    time = flight_time(speed, length(goal_x - ball.x, line_y - ball.y))
    if time > 3.0 or height_at(ball, time) > GOAL_HEIGHT + OVER_BAR:
        return
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team and player.role == GK and player.down <= 0.0:
            plan_save(match, i, goal_x, line_y, time)
            return


@kernel
def plan_save(match, i, goal_x, line_y, time):
    """Draw whether keeper i saves a shot that crosses his line in `time` s, and choose where he means to meet it."""
    player, ball = match.players[i], match.ball
    to_x, to_y = goal_x - ball.x, line_y - ball.y
    to_line = length(to_x, to_y)
    gap = abs((player.x - ball.x) * to_y - (player.y - ball.y) * to_x) / to_line
    match.saver, match.save_gap = i, gap
    effort = choose_meeting(match, player, to_x / to_line, to_y / to_line, to_line)
    match.save_succeeds = uniform(match) < save_chance(player, gap, time) and effort < DIVE_SPEED
    player.turning = READY


@kernel
def choose_meeting(match, player, ux, uy, to_line):
    """Choose the place between the shot's closest point and the line that costs a keeper least; return that, in m/s."""
    ball = match.ball
    speed = ball_speed(ball)
    here_x, here_y = player.x + STRIDE * player.vx, player.y + STRIDE * player.vy
    closest = (here_x - ball.x) * ux + (here_y - ball.y) * uy
    closest = to_line if closest < -0.3 else min(max(closest, 0.3), to_line)
    least = math.inf
    for k in range(MEETING_PLACES):
        distance = closest + k / (MEETING_PLACES - 1) * (to_line - closest)
        x, y = ball.x + distance * ux, ball.y + distance * uy
        time = flight_time(speed, distance)
        effort = max(length(x - here_x, y - here_y) - ARM, 0.0) / max(time - DIVE_DELAY, 0.02)
        if effort < least:
            least = effort
            match.save_x, match.save_y, match.save_wait = x, y, time
    return least


@kernel
def save_chance(player, gap, time):
    """Chance of saving a shot that passes `gap` m away and crosses the line in `time` s."""
    if not in_own_box(player):
        return FOOT_CHANCE if gap < FOOT_GAP else 0.0
    wide = min(max((gap - GAP_NEAR) / GAP_WIDE, 0.0), 1.0)
    logit = SAVE_BASE - SAVE_TIME * time + SAVE_WIDE * wide + SAVE_SKILL * (MEASURED_SKILL - player.skill)
    chance = 1.0 / (1.0 + math.exp(logit))
    return max(chance, 1.0 - BODY_BEATEN) if gap < BODY_GAP else chance


@kernel
def height_at(ball, time):
    """Height in m of a ball after this time of free flight."""
    return ball.z + ball.vz * time - 4.9 * time * time
