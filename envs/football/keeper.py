"""The built-in goalkeeper: where he stands, when he comes out, and his kick-out.

As documented of Google Research Football. Read next: `saves`.
"""

from __future__ import annotations

import math

from envs.football.constants import (
    GOAL_HALF_WIDTH,
    HIGH_PASS,
    LEFT,
    NOBODY,
    RUN_SPEED,
)
from envs.football.control import chase, go_for_ball, run_to
from envs.football.hands import HOLD_STEPS
from envs.football.possession import ball_speed, meeting_time
from envs.football.saves import dive, own_goal_x
from envs.football.vectors import apart, length, toward
from scenic_lite.jit import kernel

# Standing
HIGH_LINE = 10.0  # m before the goal line while the ball is in the other half
LINE_LEAST = 0.7  # m
ASTRAY = 3.0  # m from where he should be: he sprints
ADVANCE = 0.3  # share of the way to the ball while his team has it

# Coming out
CLAIM_MARGIN = 0.15  # s by which he must be first at a loose ball
CLAIM_RANGE = 30.0  # m from the goal line
RUSH_NEAR, RUSH_SHARE = 2.5, 0.8  # m; share of his distance at which he joins the line from ball to goal

GIVEN_UP = -0.4  # s, `save_wait` of a shot that is no longer expected

# Against two
SECOND_RANGE, SECOND_FREE, SECOND_SHARE = 27.0, 4.0, 0.3  # m from the goal; m to his marker; share of the way out

# Distribution
THROW_FREE = 10.0  # m from the nearest opponent: a mate to whom the ball may go
THROW_LEAST, THROW_MOST = 8.0, 40.0  # m to a free mate
HOLD_LONGEST = 40  # steps, then it goes to the nearest mate all the same
HURRY_AFTER = 30  # steps beyond which a commanded keeper kicks out by himself
MATE_LEAD = 0.4  # s by which a mate's run is led
KICK_OUT = 30.0  # m upfield when there is no mate


@kernel
def think_keeper(match, i):
    """Decide for keeper i."""
    player = match.players[i]
    if match.saver == i and match.save_wait < GIVEN_UP:
        match.saver = NOBODY  # the shot never came: wide, off the post, or too slow
    if match.holder == i:
        player.want_x, player.want_y = 0.0, 0.0
        match.hold_wait -= 1
        if player.kick == 0 and match.hold_wait < 0:
            distribute(match, i)
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
        if match.hold_wait < -HURRY_AFTER and match.players[i].kick == 0:
            kick_out(match, i)


@kernel
def distribute(match, i):
    """Kick the ball out once the nearest mate has no opponent near him, or the ball has been held for too long."""
    mate = nearest_mate(match, i, 0.0)
    if mate == NOBODY or not opposed(match, mate, THROW_FREE) or match.hold_wait < HOLD_STEPS - HOLD_LONGEST:
        kick_out(match, i)


@kernel
def kick_out(match, i):
    """Kick or throw the ball high to the nearest free mate some way off, else to the nearest, or simply upfield."""
    player = match.players[i]
    forward = 1.0 if player.team == LEFT else -1.0
    player.aim_x, player.aim_y = player.x + forward * KICK_OUT, player.y
    j = nearest_mate(match, i, THROW_FREE)
    if j == NOBODY or apart(match.players[j], player) > THROW_MOST:
        j = nearest_mate(match, i, 0.0)
    if j != NOBODY:
        mate = match.players[j]
        player.aim_x, player.aim_y = mate.x + MATE_LEAD * mate.vx, mate.y + MATE_LEAD * mate.vy
    player.kick, player.kick_held, player.kick_ready, player.aimed = HIGH_PASS, 1, True, True
    player.kick_mate = j


@kernel
def nearest_mate(match, i, free):
    """Return player i's nearest mate, but not a very near one, who has no opponent within `free` m, -1 if none."""
    player = match.players[i]
    best, nearest = NOBODY, math.inf
    for j in range(match.num_players):
        mate = match.players[j]
        distance = apart(mate, player)
        if j == i or mate.team != player.team or mate.off:
            continue
        if THROW_LEAST < distance < nearest and not opposed(match, j, free):
            best, nearest = j, distance
    return best


@kernel
def opposed(match, j, within):
    """Tell whether player j has an opponent within so many m."""
    player = match.players[j]
    for k in range(match.num_players):
        rival = match.players[k]
        if rival.team != player.team and apart(rival, player) < within:
            return True
    return False


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
    if second_attacker(match, i, match.carrier):
        share = max(share, 1.0 - SECOND_SHARE)
        run_to(player, ball.x + share * (goal_x - ball.x), ball.y * (1.0 - share), player.top_speed)
        return
    to_x, to_y = toward(ball.x + share * (goal_x - ball.x) - player.x, ball.y * (1.0 - share) - player.y)
    player.want_x, player.want_y = to_x * player.top_speed, to_y * player.top_speed  # no slower near that place


@kernel
def second_attacker(match, i, first):
    """Tell whether an opponent other than `first` is near keeper i's goal and unmarked: then he must not go all out."""
    goal_x = own_goal_x(match.players[i].team)
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == match.players[i].team or j == first:
            continue
        if length(goal_x - rival.x, rival.y) < SECOND_RANGE and not marked(match, i, j):
            return True
    return False


@kernel
def marked(match, i, j):
    """Tell whether a mate of keeper i is close to opponent j."""
    for k in range(match.num_players):
        mate = match.players[k]
        if k != i and mate.team == match.players[i].team and apart(mate, match.players[j]) < SECOND_FREE:
            return True
    return False


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
    return (meeting_time(match, player, speed) + CLAIM_MARGIN < meeting_time(match, match.players[rival], speed)) or (
        through_on_goal(match, i) and not second_attacker(match, i, rival)
    )


@kernel
def lone(match, i):
    """Tell whether keeper i's team has no other player: every ball in his half is his."""
    mates = 0
    for j in range(match.num_players):
        mates += match.players[j].team == match.players[i].team and not match.players[j].off
    return mates == 1


@kernel
def through_on_goal(match, i):
    """Tell whether no mate of keeper i stands closer to his goal than the ball does."""
    goal_x = own_goal_x(match.players[i].team)
    ball = match.ball
    danger = length(goal_x - ball.x, ball.y)
    for j in range(match.num_players):
        mate = match.players[j]
        if j == i or mate.team != match.players[i].team or mate.off:
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
    x, y = goal_x + out * dx / distance, foot_y + out * dy / distance
    astray = length(x - player.x, y - player.y) > ASTRAY
    run_to(player, x, y, player.top_speed if astray else RUN_SPEED)


@kernel
def bisector_foot(dx, y):
    """y at which the bisector of the angle from a ball at (dx, y) to both posts meets the goal line."""
    near, far = length(dx, y - GOAL_HALF_WIDTH), length(dx, y + GOAL_HALF_WIDTH)
    return GOAL_HALF_WIDTH * (far - near) / (far + near + 1e-9)
