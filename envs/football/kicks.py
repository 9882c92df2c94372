"""Kicks: when the leg swings, where a shot goes, which mate a pass is for, and how fast the ball leaves.

The rules and numbers are those measured of, or documented for, Google Research Football. Read next: `keeper`.
"""

from __future__ import annotations

import math

from envs.football.constants import (
    BALL_RADIUS,
    DIRECTION_X,
    DIRECTION_Y,
    DT,
    HALF_LENGTH,
    HIGH_PASS,
    LEFT,
    LONG_PASS,
    NOBODY,
    SHOT,
)
from envs.football.possession import forget_kick, lose_ball
from envs.football.saves import foresee_shot
from envs.football.vectors import apart, length
from scenic_lite.jit import kernel
from scenic_lite.stream import normal

KICK_REACH = 1.2  # m from the body to the ball when the leg swings
SWING = 0.16  # s from the command to the contact, facing the target
TURN_TO_SIDE, TURN_ROUND = 0.22, 0.28  # s more for the first and for the second quarter turn
SWING_PATIENCE = -0.6  # s, `kick_wait` at which a kick that never met the ball is given up
AFTER_KICK = 0.45  # s until the kicker can touch the ball again

# Shots
SHOT_STANDING, SHOT_RUNNING = 27.4, 31.8  # m/s
RUNNING_FROM = 1.5  # m/s
CHARGE_STANDING, CHARGE_RUNNING, CHARGE_STEPS = 0.4, 1.0, 5  # m/s per further step that the button was held
SHOT_TURNED = -5.0  # m/s at a quarter turn, growing with its cube
SHOT_SPREAD = 1.0  # m/s
LIFT_STANDING, LIFT_RUNNING, LIFT_TURNED = 4.2, 2.7, 1.2  # m/s upwards
LIFT_SPREAD, LIFT_LEAST = 1.1, 0.3  # m/s
AIM_WIDEST, AIM_POWER = 3.33, 0.7  # m from the middle of the goal when aiming a quarter turn off
DRIFT, DRIFT_POWER = 0.3, 1.3  # rad further out than aimed, at a quarter turn
SCATTER, SCATTER_TURNED = 0.02, 0.07  # rad
SHOT_SPIN = -1.5  # m/s

# Passes
PASS_SPEED, PASS_BASE = 36.0, 0.3  # m/s; share of it at no distance
GROUND_GAIN, HIGH_GAIN, GAIN_POWER, GAIN_DISTANCE = 1.8, 1.15, 1.4, 60.0  # m
GROUND_CAP, HIGH_CAP, EXCESS_LIFT = 26.0, 38.0, 0.2
GROUND_LIFT = 0.11  # tangent of the elevation
GROUND_SPIN, HIGH_SPIN = 5.2, -1.9  # m/s
LONG_LEAD = 0.2  # of the distance, towards the goal
MATE_LEAD = 0.4  # s by which a mate's run is led
PASS_SCATTER = 0.015  # rad
LOOK_SHORT, LOOK_LONG, LOOK_HIGH = 6.6, 7.7, 10.6  # m ahead, the place that mates are rated by
LOOK_SCALE, LOOK_WEIGHT, LOOK_POWER = 70.0, 0.8, 0.8
UNAIMED_PASS = 12.0  # m, a pass when there is no mate


@kernel
def swing_legs(match):
    """Start the swing of whoever is to kick and has the ball."""
    i = match.carrier
    if i == NOBODY or match.kicker != NOBODY:
        return
    player = match.players[i]
    if not player.kick_ready or player.kick == 0 or apart(match.ball, player) > KICK_REACH:
        return
    if not player.aimed:
        aim(match, i)
    dx, dy = player.aim_x - player.x, player.aim_y - player.y
    player.kick_wait = swing_time(quarter_turns(player.facing_x, player.facing_y, dx, dy))
    match.kicker = i


@kernel
def swing_time(turns):
    """Seconds from the command to the contact when the body must turn by so many quarter turns."""
    return SWING + TURN_TO_SIDE * min(turns, 1.0) + TURN_ROUND * max(turns - 1.0, 0.0)


@kernel
def quarter_turns(ax, ay, bx, by):
    """Angle between two directions in quarter turns, 0 to 2."""
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by)) / (0.5 * math.pi)


@kernel
def swing_frame(match):
    """Count the kicker's swing down by a frame; return True when the ball has left his foot."""
    i = match.kicker
    player = match.players[i]
    player.kick_wait -= DT
    if player.kick_wait > 0.0:
        return False
    if match.carrier != i or player.kick_wait < SWING_PATIENCE:
        forget_kick(player)
        match.kicker = NOBODY
        return False
    if apart(match.ball, player) > KICK_REACH:
        return False
    leave_foot(match, i)
    return True


@kernel
def input_direction(player):
    """Return the direction that aims a kick: the sticky key, or where the player looks."""
    if player.direction > 0:
        return DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    return player.facing_x, player.facing_y


@kernel
def aim(match, i):
    """Set where player i's kick is meant to go."""
    player = match.players[i]
    ux, uy = input_direction(player)
    if player.kick == SHOT:
        aim_shot(match.ball, player, ux, uy)
    else:
        aim_pass(match, i, ux, uy)


@kernel
def aim_shot(ball, player, ux, uy):
    """Aim at the goal line: the further the keys point off the middle of the goal, the further off it."""
    goal_x = HALF_LENGTH if player.team == LEFT else -HALF_LENGTH
    dx, dy = goal_x - ball.x, -ball.y
    deviation = math.atan2(dx * uy - dy * ux, dx * ux + dy * uy) / (0.5 * math.pi)
    turns = min(abs(deviation), 1.0)
    side = 1.0 if deviation * dx > 0.0 else -1.0
    player.aim_x = goal_x
    player.aim_y = side * AIM_WIDEST * turns**AIM_POWER
    drift = DRIFT * turns**DRIFT_POWER * min(2.0 - abs(deviation), 1.0)
    distance = length(dx, player.aim_y - ball.y)
    player.aim_y += side * math.tan(drift) * distance


@kernel
def aim_pass(match, i, ux, uy):
    """Aim at the mate whom the original's rating prefers; without one, straight ahead."""
    player = match.players[i]
    mate = choose_mate(match, i, ux, uy)
    player.kick_mate = mate
    if mate == NOBODY:
        player.aim_x, player.aim_y = player.x + UNAIMED_PASS * ux, player.y + UNAIMED_PASS * uy
        return
    receiver = match.players[mate]
    player.aim_x = receiver.x + MATE_LEAD * receiver.vx
    player.aim_y = receiver.y + MATE_LEAD * receiver.vy
    if player.kick == LONG_PASS:
        goal_x = HALF_LENGTH if player.team == LEFT else -HALF_LENGTH
        distance = length(player.aim_x - player.x, player.aim_y - player.y)
        to_goal_x, to_goal_y = goal_x - player.aim_x, -player.aim_y
        lead = LONG_LEAD * distance / max(length(to_goal_x, to_goal_y), 1.0)
        player.aim_x += lead * to_goal_x
        player.aim_y += lead * to_goal_y


@kernel
def choose_mate(match, i, ux, uy):
    """Return the mate for a pass along (ux, uy): near a point ahead and not far off the direction."""
    player = match.players[i]
    look = LOOK_HIGH if player.kick == HIGH_PASS else (LOOK_LONG if player.kick == LONG_PASS else LOOK_SHORT)
    look_x, look_y = player.x + look * ux, player.y + look * uy
    best, best_rating = NOBODY, math.inf
    for j in range(match.num_players):
        mate = match.players[j]
        if j == i or mate.team != player.team or mate.off:
            continue
        off = 0.5 * quarter_turns(ux, uy, mate.x - player.x, mate.y - player.y)
        far = length(mate.x - look_x, mate.y - look_y) / LOOK_SCALE
        rating = LOOK_WEIGHT * far**LOOK_POWER + off
        if rating < best_rating:
            best, best_rating = j, rating
    return best


@kernel
def leave_foot(match, i):
    """Send the ball off player i's foot."""
    player = match.players[i]
    dx, dy = player.aim_x - match.ball.x, player.aim_y - match.ball.y
    distance = length(dx, dy)
    if distance < 0.1:  # to his own feet: straight ahead
        dx, dy, distance = 0.1 * player.facing_x, 0.1 * player.facing_y, 0.1
    ux, uy = dx / distance, dy / distance
    if player.kick == SHOT:
        shoot(match, player, ux, uy)
    else:
        play_pass(match, player, ux, uy, distance)
    player.facing_x, player.facing_y = ux, uy
    player.touch_wait = AFTER_KICK
    match.receiver = player.kick_mate
    forget_kick(player)
    lose_ball(match)
    match.last_touch = i
    foresee_shot(match, player.team)


@kernel
def shoot(match, player, ux, uy):
    """Give the ball the velocity of a shot along (ux, uy), with the scatter of a body that had to turn."""
    turns = min(quarter_turns(player.facing_x, player.facing_y, ux, uy), 1.0)
    pace = min(length(player.vx, player.vy) / RUNNING_FROM, 1.0)
    charge = min(max(player.kick_held - 1, 0), CHARGE_STEPS)
    speed = SHOT_STANDING + (SHOT_RUNNING - SHOT_STANDING) * pace + SHOT_TURNED * turns * turns * turns
    speed += charge * (CHARGE_STANDING + (CHARGE_RUNNING - CHARGE_STANDING) * pace)
    speed += SHOT_SPREAD * normal(match)
    lift = LIFT_STANDING + (LIFT_RUNNING - LIFT_STANDING) * pace + LIFT_TURNED * turns
    lift += LIFT_SPREAD * normal(match)
    off = (SCATTER + SCATTER_TURNED * turns * turns) / player.skill * normal(match)
    send(match.ball, ux, uy, off, speed, max(lift, LIFT_LEAST), SHOT_SPIN)


@kernel
def play_pass(match, player, ux, uy, distance):
    """Give the ball the velocity of a pass over this distance."""
    far = (distance / GAIN_DISTANCE) ** GAIN_POWER
    if player.kick == HIGH_PASS:
        speed = min(PASS_SPEED * (PASS_BASE + HIGH_GAIN * far), HIGH_CAP)
        rise = 0.45 - 0.15 * min(1.0, distance / GAIN_DISTANCE)
        excess, spin = 0.0, HIGH_SPIN
    else:
        wanted = PASS_SPEED * (PASS_BASE + GROUND_GAIN * far)
        speed = min(wanted, GROUND_CAP)
        rise = GROUND_LIFT
        excess, spin = EXCESS_LIFT * min(wanted - speed, 10.0), GROUND_SPIN
    flat = speed / math.sqrt(1.0 + rise * rise)
    off = PASS_SCATTER / player.skill * normal(match)
    send(match.ball, ux, uy, off, flat, flat * rise + excess, spin)


@kernel
def send(ball, ux, uy, off, speed, lift, spin):
    """Set the ball's velocity: `speed` in m/s along (ux, uy) turned by `off` rad, `lift` upwards."""
    cosine, sine = math.cos(off), math.sin(off)
    wx, wy = ux * cosine - uy * sine, ux * sine + uy * cosine
    ball.vx, ball.vy, ball.vz = speed * wx, speed * wy, lift
    ball.spin_x, ball.spin_y = spin * wx, spin * wy
    ball.z = max(ball.z, BALL_RADIUS)
