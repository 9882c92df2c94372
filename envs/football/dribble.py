"""Running with the ball: the body and the ball together.

A touch sends the ball ahead, somewhat faster than its player runs; it rolls free, slows down, and when he has caught
up with it, it is touched again. Anybody can take it meanwhile. Going for a touch holds him back for two steps, and
in a sprint he can change direction only around a touch: hence wide arcs. Speeds, distances and rhythms are fitted to
traces of Google Research Football. Read next: `contacts`, where others meet the ball.
"""

from __future__ import annotations

import math

from envs.football.constants import BALL_RADIUS, NOBODY, NORMAL, RUN_SPEED, STEP
from envs.football.running import JUMP, SETTLED, SPRINTING, UNDER_WAY, gain, redirect, run_free, straight
from envs.football.vectors import toward
from scenic_lite.jit import kernel

TOUCH_REACH = 1.15  # m from the body to a ball that the foot can still play
TOUCH_BELOW = 0.9  # m
WALKING = 0.5  # m/s, slower players keep the ball at the foot
AT_FOOT = 0.38  # m ahead of a player who stands
AT_FOOT_TIME, AT_FOOT_SPEED = 0.1, 3.0  # s; m/s at most, relative to the player: how it is put there

# How one runs with the ball, by the speed wanted: at a dribble, at a run, at a sprint, knocking it on in a sprint
DRIBBLING, RUNNING, SPRINTED, KNOCKED_ON = range(4)
DRIBBLE_BELOW = 4.7  # m/s wanted
NEXT_TOUCH = (0.5, 0.52, 0.93, 1.05)  # m ahead at which he goes for the next touch
SLOWER = 0.1  # m/s, so much faster than the player the ball may be then
HELD_BACK = (0.4, 0.1, 0.75, 0.5)  # m/s, while he does, at a run or faster; slower, by the square of the speed
HELD_TURNING = 0.5  # m/s, while he sends it elsewhere
PUSHED_PACE = (1.1, 1.1, 1.1, 1.36)  # a touch gives the ball this times his speed
PUSHED_MORE = (1.5, 2.0, 1.9, 3.5)  # m/s and this more,
PUSHED_MOST = (0.15, 0.33, 0.85, 3.9)  # m/s but at most this more than he wants to run
PUSHED_UP = (0.0, 0.3, 0.0, 1.2)  # m/s upwards
TURNED_BALL, TURNS_BELOW = 1.4, 6.9  # m/s of a ball that is turned back; m/s at which he does that
SLOWED_BALL = 1.2  # m/s less than his speed, where he stops
ASIDE_TIME, ASIDE = 0.4, 2.0  # s in which a touch brings the ball back to his line, m/s at most
FOLLOWS, FOLLOWS_PACE = 0.95, 0.9  # m ahead, share of his speed: a ball that he must follow before he can turn back
HOLDING = 2  # steps for which going for a touch holds him back; in the second he plays the ball
BACK_BELOW = -0.3  # cosine of the angle to the wanted direction; below it he has to stop first
TOUCH_PACE = 0.92  # of the speed wanted: the pace that is left when a sprinter plays the ball

# Sprints
ARC_STEPS = 5  # steps around a touch in which a sprint can change direction
ARC = 0.075  # rad, in each of them
ARC_COS, ARC_SIN = math.cos(ARC), math.sin(ARC)
ARC_STRAIGHT = 0.9999  # cosine of an angle that needs no turn
ARC_AHEAD_COS, ARC_AHEAD_SIN = math.cos(3.0 * ARC), math.sin(3.0 * ARC)  # of the touch, for what is still to turn
ARC_PACE, ARC_EASING = 0.875, 3.0  # of the speed wanted, while he turns; m/s² down to it
ARC_EFFORT = 0.87  # share of full effort with which he gathers speed again
EASING = 8.0  # m/s², to a slower gait

# Turns and stops
LAG = (0.4, 0.6, 0.8, 1.0)  # share of full effort in the steps since command and velocity differ
LAG_SPRINT = (0.0, 0.25, 0.9, 1.0)
BRAKE_EARLY = 1.6  # times that share, but at most 1: he brakes before he gathers speed again
BRAKING = 7.7  # m/s², of what leads aside
BRAKING_BACK, BRAKING_LATE, LATE = 18.0, 7.0, 3.6  # m/s² of a run that is to go back; when slower than this, m/s,
BRAKING_ASIDE = 8.5  # and m/s² more where it is not to go straight back, times one plus the cosine
STOPPING, STOPPING_LATE, STOPS_LATE = 13.0, 16.0, 4.0  # m/s²; m/s
FRESH = 11.0  # m/s² in a new direction


@kernel
def run_with_ball(match, i, speed):
    """Velocity after a step of running with the ball towards the wanted velocity; and decide about the next touch."""
    player, ball = match.players[i], match.ball
    away_x, away_y = ball.x - player.x, ball.y - player.y
    if player.stride < 99:
        player.stride += 1
    if away_x * away_x + away_y * away_y > TOUCH_REACH * TOUCH_REACH or ball.z > TOUCH_BELOW:
        player.held = 0.0
        return run_free(player, speed)
    if player.held > 0.0 and speed > 0.0:
        faster = 1.0 + player.held / speed
        player.vx *= faster
        player.vy *= faster
        speed += player.held
    want = math.sqrt(player.want_x * player.want_x + player.want_y * player.want_y)
    gait = gait_of(player, max(want, speed))
    turned = turns_off(player, speed, want)
    if player.stride >= HOLDING and touch_due(ball, player, speed, want, gait):
        player.stride = 0
    vx, vy = player.vx, player.vy
    if not out_runs(ball, player, speed, away_x, away_y):
        vx, vy = steered(player, speed, want)
    player.held = 0.0
    speed = math.sqrt(vx * vx + vy * vy)
    if player.stride < HOLDING and want > WALKING and speed > 0.0:
        held = HELD_BACK[gait]
        if turned:
            held = HELD_TURNING if gait < SPRINTED else 0.0
        player.held = held * min(speed * speed / (RUN_SPEED * RUN_SPEED), 1.0)
        vx *= 1.0 - player.held / speed
        vy *= 1.0 - player.held / speed
    return vx, vy


@kernel
def out_runs(ball, player, speed, away_x, away_y):
    """Tell whether the ball is still ahead of a sprinter who has just pushed it on: he cannot but follow."""
    if speed < SPRINTING:
        return False
    ahead = (away_x * player.vx + away_y * player.vy) / speed
    along = (ball.vx * player.vx + ball.vy * player.vy) / speed
    wants_back = player.vx * player.want_x + player.vy * player.want_y < 0.0
    return wants_back and ahead > FOLLOWS and along > FOLLOWS_PACE * speed


@kernel
def turns_off(player, speed, want):
    """Tell whether a player wants to run elsewhere than he does, by more than a step's arc."""
    return player.vx * player.want_x + player.vy * player.want_y < ARC_COS * speed * want


@kernel
def gait_of(player, want):
    """How a player runs with the ball who wants, or has, this speed."""
    if want < DRIBBLE_BELOW:
        return DRIBBLING
    if want < SPRINTING:
        return RUNNING
    return KNOCKED_ON if player.sprint and player.dribble else SPRINTED


@kernel
def steered(player, speed, want):
    """Velocity after a step with the ball, were he not held back by a touch."""
    dx, dy = player.want_x - player.vx, player.want_y - player.vy
    if dx * dx + dy * dy < SETTLED * SETTLED:
        player.turning = 0
        return player.want_x, player.want_y
    along = player.vx * player.want_x + player.vy * player.want_y
    cosine = along / (speed * want) if speed > 1e-6 and want > 1e-6 else 1.0
    sprinting = speed > SPRINTING - 0.5
    if sprinting and cosine > BACK_BELOW and want > SPRINTING:
        player.turning = 0
        return arc(player, speed, want, cosine)
    if straight(player, speed):
        player.turning = 0
        return redirect(player, want, 0.0, 1.0, 0.0)
    effort = LAG_SPRINT[min(player.turning, 3)] if sprinting else LAG[min(player.turning, 3)]
    if speed < UNDER_WAY:
        effort = min(player.turning, 1)
    player.turning += 1
    if effort == 0.0:
        return player.vx, player.vy
    if sprinting and cosine > BACK_BELOW:
        return eased(player, speed, want, EASING * effort * STEP)
    if want < 1e-6:
        power = STOPPING if speed > STOPS_LATE else STOPPING_LATE
    elif cosine < BACK_BELOW:
        power = BRAKING_BACK
        if speed < LATE:
            power = BRAKING_LATE * max(want / RUN_SPEED, 1.0) + BRAKING_ASIDE * (1.0 + cosine)
    else:
        power = BRAKING
    braking = power * min(BRAKE_EARLY * effort, 1.0) * STEP
    return redirect(player, want, braking, effort, FRESH * effort * effort * STEP)


@kernel
def eased(player, speed, want, loss):
    """Velocity after a step in which a sprint with the ball comes down to a slower gait, by `loss` m/s."""
    new = max(speed - loss, want)
    ux, uy = player.vx / speed, player.vy / speed
    if want > 1e-6:
        ux, uy = bent(ux, uy, player.want_x / want, player.want_y / want, ARC_COS, ARC_SIN)
    return ux * new, uy * new


@kernel
def arc(player, speed, want, cosine):
    """Velocity after a step of a sprint with the ball: it changes direction only around a touch, which costs pace."""
    ux, uy = player.vx / speed, player.vy / speed
    if cosine < ARC_STRAIGHT and player.stride < ARC_STEPS:
        new = speed - ARC_EASING * STEP if speed > want * ARC_PACE else speed
        wx, wy = bent(ux, uy, player.want_x / want, player.want_y / want, ARC_COS, ARC_SIN)
        return wx * new, wy * new
    most = max(want, speed) if player.stride >= HOLDING else want * TOUCH_PACE
    new = min(speed + gain(speed, player.top_speed, ARC_EFFORT), most)
    return ux * new, uy * new


@kernel
def bent(ux, uy, wx, wy, cosine, sine):
    """Turn the unit vector u towards the unit vector w, by the angle of this cosine and sine at most."""
    if ux * wx + uy * wy >= cosine:
        return wx, wy
    if ux * wy - uy * wx < 0.0:
        sine = -sine
    return ux * cosine - uy * sine, ux * sine + uy * cosine


@kernel
def play_direction(player, vx, vy, want):
    """Unit vector along which a player wants the ball: where he wants to go, in a sprint not too far off his run v."""
    if want < WALKING:
        return player.facing_x, player.facing_y
    wx, wy = player.want_x / want, player.want_y / want
    speed = math.sqrt(vx * vx + vy * vy)
    if speed > SPRINTING - 0.5 and vx * wx + vy * wy > BACK_BELOW * speed:
        return bent(vx / speed, vy / speed, wx, wy, ARC_AHEAD_COS, ARC_AHEAD_SIN)
    return wx, wy


@kernel
def touch_due(ball, player, speed, want, gait):
    """Tell whether a player goes for his next touch in this step."""
    ux, uy = play_direction(player, player.vx, player.vy, want)
    along = ball.vx * ux + ball.vy * uy
    ahead = (ball.x - player.x) * ux + (ball.y - player.y) * uy
    if want < WALKING:
        return along > 0.5 and (gait < SPRINTED or ahead < NEXT_TOUCH[gait] + 0.2)
    if player.vx * ux + player.vy * uy < BACK_BELOW * speed:
        return along < 0.5 * TURNED_BALL and speed < TURNS_BELOW
    return ahead < NEXT_TOUCH[gait] and along < max(player.vx * ux + player.vy * uy, JUMP) + SLOWER


@kernel
def lead_ball(match):
    """Let the carrier touch the ball if it is his turn to; return whether he did."""
    i = match.carrier
    if i == NOBODY or match.holder != NOBODY or match.game_mode != NORMAL:
        return False
    player, ball = match.players[i], match.ball
    kicking = match.kicker == i
    if (player.touch_wait > 0.0 and not kicking) or player.down > 0.0 or ball.z > TOUCH_BELOW:
        return False
    away_x, away_y = ball.x - player.x, ball.y - player.y
    if away_x * away_x + away_y * away_y > TOUCH_REACH * TOUCH_REACH:
        return False
    speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
    want = math.sqrt(player.want_x * player.want_x + player.want_y * player.want_y)
    if kicking:
        ux, uy = toward(player.aim_x - player.x, player.aim_y - player.y)
        put_at_foot(ball, player, ux, uy)
    elif want < WALKING and speed < WALKING:
        put_at_foot(ball, player, player.facing_x, player.facing_y)
    elif player.stride == HOLDING - 1:
        faster = 1.0 + player.held / max(speed, WALKING)
        push_on(ball, player, player.vx * faster, player.vy * faster, want)
    else:
        return False
    return True


@kernel
def put_at_foot(ball, player, ux, uy):
    """Play the ball to the foot of a player who stands, or is about to kick it along u."""
    push_x = (player.x + AT_FOOT * ux - ball.x) / AT_FOOT_TIME
    push_y = (player.y + AT_FOOT * uy - ball.y) / AT_FOOT_TIME
    push = math.sqrt(push_x * push_x + push_y * push_y)
    if push > AT_FOOT_SPEED:
        push_x, push_y = push_x / push * AT_FOOT_SPEED, push_y / push * AT_FOOT_SPEED
    roll(ball, player.vx + push_x, player.vy + push_y)


@kernel
def push_on(ball, player, vx, vy, want):
    """Send the ball where its player, whose run is v but for the touch, wants to go, and back to his line."""
    ux, uy = play_direction(player, vx, vy, want)
    pace, speed = vx * ux + vy * uy, math.sqrt(vx * vx + vy * vy)
    if want < WALKING:
        fast = max(speed - SLOWED_BALL, 0.0) if speed > STOPS_LATE else 0.0
    elif pace < BACK_BELOW * speed:
        fast = TURNED_BALL
    else:
        gait = gait_of(player, max(want, speed))
        short = NEXT_TOUCH[gait] - (ball.x - player.x) * ux - (ball.y - player.y) * uy
        fast = PUSHED_PACE[gait] * max(pace, 0.0) + PUSHED_MORE[gait]
        fast = min(fast, want + PUSHED_MOST[gait]) + min(max(1.5 * short, 0.0), 0.6)
    across = vy * ux - vx * uy  # to the left of u
    off = (ball.y - player.y) * ux - (ball.x - player.x) * uy
    aside = (across * abs(across) / (2.0 * BRAKING) - off) / ASIDE_TIME
    aside = min(max(aside, -ASIDE), ASIDE)
    roll(ball, fast * ux - aside * uy, fast * uy + aside * ux)
    if want > WALKING and pace > 0.0:
        ball.vz = PUSHED_UP[gait_of(player, max(want, speed))]


@kernel
def roll(ball, vx, vy):
    """Let the ball roll on the ground with this velocity."""
    ball.vx, ball.vy, ball.vz = vx, vy, 0.0
    ball.spin_x, ball.spin_y = vx, vy
    ball.z = BALL_RADIUS
