"""The built-in goalkeeper: where he stands, when he rushes out, which shots he will save, and his kick-out.

Positioning follows what is documented of Google Research Football; whether a shot is saved is drawn when it
leaves the foot, with odds fitted to its measured saves, and the body then moves to make the draw true.
Read next: `contacts`, where hands and ball meet.
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
    HIGH_PASS,
    LEFT,
    NOBODY,
    RUN_SPEED,
)
from envs.football.control import chase, go_for_ball, run_to
from envs.football.possession import ball_speed, meeting_time
from envs.football.rng import uniform
from envs.football.vectors import apart, length
from scenic_lite.jit import kernel

# Standing
HIGH_LINE = 10.0  # m before the goal line while the ball is in the other half
LINE_LEAST = 0.7  # m
ADVANCE = 0.3  # share of the way to the ball while his team has it

# Coming out
CLAIM_MARGIN = 0.15  # s by which he must be first at a loose ball
CLAIM_RANGE = 30.0  # m from the goal line
RUSH_NEAR, RUSH_SHARE = 2.5, 0.6  # m; share of his distance at which he joins the line from ball to goal
READY = 4  # "turning" of a body that already moves: no lag

# Saves: logit P(goal) = base − slope × time + wide × (0 .. 1 over the gaps), fitted to 433 measured shots on target
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

# Kick-out
HOLD_STEPS, HOLD_SPREAD, HOLD_LONGEST = 9, 7, 30  # steps
KICK_OUT = 30.0  # m upfield when there is no mate


@kernel
def own_goal_x(team):
    """x of the goal line that a team defends."""
    return -HALF_LENGTH if team == LEFT else HALF_LENGTH


@kernel
def in_own_box(player):
    """Tell whether a player stands in his own penalty box, where a keeper may use his hands."""
    return abs(own_goal_x(player.team) - player.x) < BOX_DEPTH and abs(player.y) < BOX_HALF_WIDTH


@kernel
def think_keeper(match, i):
    """Decide for keeper i."""
    player = match.players[i]
    if match.holder == i:
        player.want_x, player.want_y = 0.0, 0.0
        if match.hold_wait > 0:
            match.hold_wait -= 1
        elif player.kick == 0:
            kick_out(match, i)
    elif match.saver == i:
        dive(match, player)
    elif match.carrier == i:
        kick_out(match, i)
    elif should_come_out(match, i):
        if match.carrier == NOBODY:
            chase(match, i, player.top_speed)
        else:
            rush(match, i)
    else:
        stand(match, i)


@kernel
def hurry(match, i):
    """Make a commanded keeper kick the ball out when he has held it for too long."""
    if match.holder == i:
        match.hold_wait -= 1
        if match.hold_wait < -HOLD_LONGEST and match.players[i].kick == 0:
            kick_out(match, i)


@kernel
def kick_out(match, i):
    """Kick high to the nearest mate up the pitch, or simply upfield."""
    player = match.players[i]
    forward = 1.0 if player.team == LEFT else -1.0
    player.aim_x, player.aim_y = player.x + forward * KICK_OUT, player.y
    nearest = math.inf
    for j in range(match.num_players):
        mate = match.players[j]
        distance = length(mate.x - player.x, mate.y - player.y)
        if j != i and mate.team == player.team and distance < nearest:
            nearest = distance
            player.aim_x, player.aim_y = mate.x, mate.y
    player.kick, player.kick_held, player.kick_ready, player.aimed = HIGH_PASS, 1, True, True


@kernel
def dive(match, player):
    """Throw the keeper to where he means to meet the shot."""
    dx, dy = match.save_x - player.x, match.save_y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    speed = min(distance / max(match.save_wait, 0.1), DIVE_SPEED)
    share = speed / distance if distance > 0.05 else 0.0
    player.want_x, player.want_y = share * dx, share * dy


@kernel
def rush(match, i):
    """Run at the carrier, from afar along the line from the ball to the goal so as to narrow the angle."""
    player, ball = match.players[i], match.ball
    distance = apart(ball, player)
    goal_x = own_goal_x(player.team)
    to_goal = length(goal_x - ball.x, ball.y)
    if distance < RUSH_NEAR or distance > to_goal:
        go_for_ball(match, i, player.top_speed)
        return
    share = RUSH_SHARE * distance / (to_goal + 1e-9)
    run_to(player, ball.x + share * (goal_x - ball.x), ball.y * (1.0 - share), player.top_speed)


@kernel
def should_come_out(match, i):
    """Tell whether to leave the goal: for a loose ball that he reaches first, or for a carrier who is through."""
    player = match.players[i]
    ball = match.ball
    goal_x = own_goal_x(player.team)
    if ball.x * goal_x <= 0.0:
        return False
    if match.carrier == NOBODY or match.players[match.carrier].team == player.team:
        return match.carrier == NOBODY and first_at_ball(match, i)
    return through_on_goal(match, i)


@kernel
def first_at_ball(match, i):
    """Tell whether keeper i can be at a loose ball clearly before any opponent, and should be the one to go."""
    player = match.players[i]
    if abs(own_goal_x(player.team) - match.ball.x) > CLAIM_RANGE or match.chaser[player.team] != i:
        return lone(match, i)
    rival = match.chaser[1 - player.team]
    if rival == NOBODY:
        return True
    speed = ball_speed(match.ball)
    return (
        meeting_time(match, player, speed) + CLAIM_MARGIN < meeting_time(match, match.players[rival], speed)
    ) or through_on_goal(match, i)


@kernel
def lone(match, i):
    """Tell whether keeper i's team has no other player: every ball in his half is his."""
    mates = 0
    for j in range(match.num_players):
        mates += match.players[j].team == match.players[i].team
    return mates == 1


@kernel
def through_on_goal(match, i):
    """Tell whether no mate of keeper i stands closer to his goal than the ball does."""
    goal_x = own_goal_x(match.players[i].team)
    ball = match.ball
    danger = length(goal_x - ball.x, ball.y)
    for j in range(match.num_players):
        mate = match.players[j]
        if j == i or mate.team != match.players[i].team:
            continue
        if length(goal_x - mate.x, mate.y) < danger:
            return False
    return True


@kernel
def stand(match, i):
    """Stand on the line that halves the angle between ball and posts, or high while the ball is far."""
    player, ball = match.players[i], match.ball
    goal_x = own_goal_x(player.team)
    inward = -1.0 if goal_x > 0.0 else 1.0
    if ball.x * goal_x <= 0.0:
        run_to(player, goal_x + inward * HIGH_LINE, 0.0, RUN_SPEED)
        return
    foot_y = bisector_foot(ball.x - goal_x, ball.y)
    dx, dy = ball.x - goal_x, ball.y - foot_y
    distance = math.sqrt(dx * dx + dy * dy) + 1e-9
    ours = match.last_touch != NOBODY and match.players[match.last_touch].team == player.team
    out = max(ADVANCE * distance, LINE_LEAST) if ours else LINE_LEAST
    out = min(out, HIGH_LINE)
    run_to(player, goal_x + out * dx / distance, foot_y + out * dy / distance, RUN_SPEED)


@kernel
def bisector_foot(dx, y):
    """y at which the bisector of the angle from a ball at (dx, y) to both posts meets the goal line."""
    near, far = length(dx, y - GOAL_HALF_WIDTH), length(dx, y + GOAL_HALF_WIDTH)
    return GOAL_HALF_WIDTH * (far - near) / (far + near + 1e-9)


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


@kernel
def has_given_up(match, i):
    """Tell whether the shot has passed keeper i's saving point for good."""
    return match.save_wait < -0.3 or apart(match.ball, match.players[i]) > 60.0
