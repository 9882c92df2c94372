"""Built-in players whose team has the ball: shoot, pass, dribble; and support those who do.

The order of decisions is that documented of Google Research Football; their numbers are simplified.
Read next: `defence`.
"""

from __future__ import annotations

import math

from envs.football.constants import CF, HALF_LENGTH, HALF_WIDTH, LEFT, NOBODY, RUN_SPEED, SHORT_PASS, SHOT
from envs.football.control import CARRY_SPRINT, chase, run_to
from envs.football.dribble import TOUCH_REACH
from envs.football.vectors import apart, length
from scenic_lite.jit import kernel
from scenic_lite.stream import uniform

SHOT_RANGE, SHOT_SPOT = 16.0, 7.0  # m around a spot this far before the goal
SHOT_CHANCE = 0.75  # sqrt(odds) + U(0, 0.5) above this shoots
LANE_NARROW, LANE_WIDE = 0.5, 3.0  # m from an opponent to the lane: no odds, full odds
CORNER_AIM = 3.0  # m off the middle
PRESSED, PASS_RATE = 5.0, 0.25  # m to the nearest opponent; share of steps in which a pass is thought of
PASS_LEAST, PASS_MOST = 5.0, 32.0  # m
BACKWARD = 0.3  # weight of ground lost against width of the lane
FEAR_RANGE, FEAR = 10.0, 1.6  # m; repulsion of opponents against a pull of 1 to the goal
LINE_FEAR = 6.0  # m from a side line
SPRINT_ROOM = 3.5  # m of room that makes a carrier sprint
FOLLOW_X, FOLLOW_Y = 0.65, 0.3  # share of the ball's way by which the formation follows it
FORWARD_RUN = 9.0  # m that a centre forward stays ahead of the ball


@kernel
def attacked_goal_x(player):
    """x of the goal line that a player attacks."""
    return HALF_LENGTH if player.team == LEFT else -HALF_LENGTH


@kernel
def play_ball(match, i):
    """Decide for the carrier: shoot if the lane is free, pass if pressed, else dribble towards the goal."""
    player = match.players[i]
    if match.kicker == i:
        return
    if player.kick == 0 and not consider_shot(match, i):
        consider_pass(match, i)
    if apart(match.ball, player) > TOUCH_REACH:
        chase(match, i, player.top_speed)
    else:
        run_by_forces(match, i)


@kernel
def consider_shot(match, i):
    """Shoot at the best of both corners and the middle if its lane is free enough; return whether."""
    player = match.players[i]
    goal_x = attacked_goal_x(player)
    spot_x = goal_x - math.copysign(SHOT_SPOT, goal_x)
    if length(spot_x - player.x, player.y) > SHOT_RANGE:
        return False
    best, best_y = -1.0, 0.0
    for k in range(-1, 2):
        odds = lane_odds(match, i, goal_x, k * CORNER_AIM)
        if odds > best:
            best, best_y = odds, k * CORNER_AIM
    best *= max(1.0 - length(goal_x - player.x, player.y) / 40.0, 0.0)
    if math.sqrt(max(best, 0.0)) + 0.5 * uniform(match) < SHOT_CHANCE:
        return False
    ask_kick(player, SHOT, goal_x, best_y)
    player.kick_held = 1 + int(4.0 * uniform(match))
    return True


@kernel
def consider_pass(match, i):
    """When pressed, now and then pass to the mate with the freest lane, goal-side ones preferred."""
    player = match.players[i]
    if nearest_opponent(match, i) > PRESSED or uniform(match) > PASS_RATE:
        return
    own = length(attacked_goal_x(player) - player.x, player.y)
    best, best_rating = NOBODY, 0.35
    for j in range(match.num_players):
        mate = match.players[j]
        distance = apart(mate, player)
        if j == i or mate.team != player.team or not PASS_LEAST < distance < PASS_MOST:
            continue
        gain = (own - length(attacked_goal_x(player) - mate.x, mate.y)) / distance
        rating = lane_odds(match, i, mate.x, mate.y) + BACKWARD * gain
        if rating > best_rating:
            best, best_rating = j, rating
    if best != NOBODY:
        mate = match.players[best]
        ask_kick(player, SHORT_PASS, mate.x + 0.4 * mate.vx, mate.y + 0.4 * mate.vy)


@kernel
def ask_kick(player, kick, x, y):
    """Ask for a kick to a chosen place."""
    player.kick, player.kick_held, player.kick_ready = kick, 1, True
    player.aimed, player.aim_x, player.aim_y = True, x, y


@kernel
def lane_odds(match, i, x, y):
    """Odds in [0, 1] that no opponent of player i reaches the lane from him to (x, y)."""
    player = match.players[i]
    dx, dy = x - player.x, y - player.y
    distance = length(dx, dy) + 1e-9
    widest = LANE_WIDE
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == player.team:
            continue
        along = ((rival.x - player.x) * dx + (rival.y - player.y) * dy) / distance
        if 0.0 < along < distance:
            across = abs((rival.x - player.x) * dy - (rival.y - player.y) * dx) / distance
            widest = min(widest, across)
    return min(max((widest - LANE_NARROW) / (LANE_WIDE - LANE_NARROW), 0.0), 1.0)


@kernel
def nearest_opponent(match, i):
    """Distance in m to player i's nearest opponent."""
    player = match.players[i]
    nearest = math.inf
    for j in range(match.num_players):
        if match.players[j].team != player.team:
            nearest = min(nearest, apart(match.players[j], player))
    return nearest


@kernel
def run_by_forces(match, i):
    """Dribble where the goal pulls and opponents and side lines push; sprint when there is room."""
    player = match.players[i]
    to_x, to_y = attacked_goal_x(player) - player.x, -player.y
    distance = length(to_x, to_y) + 1e-9
    force_x, force_y = to_x / distance, to_y / distance
    nearest = math.inf
    for j in range(match.num_players):
        rival = match.players[j]
        away = apart(rival, player)
        if rival.team == player.team or away > FEAR_RANGE:
            continue
        nearest = min(nearest, away)
        push = FEAR * (1.0 - away / FEAR_RANGE) / (away + 0.1)
        force_x += push * (player.x - rival.x)
        force_y += push * (player.y - rival.y)
    room = HALF_WIDTH - abs(player.y)
    if room < LINE_FEAR:
        force_y -= math.copysign(1.0 - room / LINE_FEAR, player.y)
    speed = player.top_speed * CARRY_SPRINT if nearest > SPRINT_ROOM else RUN_SPEED
    size = length(force_x, force_y) + 1e-9
    player.want_x, player.want_y = force_x / size * speed, force_y / size * speed


@kernel
def support(match, i):
    """Run to the place that the formation gives player i for where the ball is."""
    player, ball = match.players[i], match.ball
    x, y = formation_place(match, i)
    if player.role >= CF:
        forward = 1.0 if player.team == LEFT else -1.0
        x = max(x * forward, ball.x * forward + FORWARD_RUN) * forward
    distance = length(x - player.x, y - player.y)
    run_to(player, x, y, player.top_speed if distance > 12.0 else RUN_SPEED)


@kernel
def formation_place(match, i):
    """Place of player i in a block that slides with the ball and keeps the shape of the kick-off."""
    player, ball = match.players[i], match.ball
    x = player.start_x + FOLLOW_X * (ball.x - match.ball_start_x)
    y = player.start_y + FOLLOW_Y * (ball.y - match.ball_start_y)
    limit = HALF_LENGTH - 3.0
    return min(max(x, -limit), limit), min(max(y, -HALF_WIDTH + 2.0), HALF_WIDTH - 2.0)
