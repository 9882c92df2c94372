"""Running with the ball: the body and the ball together.

A touch sends the ball ahead, somewhat faster than its player runs; it rolls free, slows down, and when he has caught
up with it, it is touched again. Anybody can take it meanwhile. Going for a touch he lunges: at a dribble he is faster
for a moment, at a sprint slower. It may begin and end within a step, which then has its share of it. In a sprint he
can change direction only around a touch: hence wide arcs. Speeds, distances and rhythms are fitted to traces of
Google Research Football. Read next: `skills.contacts`, where others meet the ball.
"""

from __future__ import annotations

import math

from envs.football.constants import BALL_RADIUS, NOBODY, NORMAL, RUN_SPEED, STEP
from envs.football.physics.running import JUMP, SETTLED, SPRINTING, SURE, UNDER_WAY, gain, redirect, run_free, straight
from envs.football.physics.vectors import toward
from scenic_lite.kernels.jit import kernel

TOUCH_REACH = 1.15  # m from the body to a ball that the foot can still play
TOUCH_BELOW = 0.9  # m
WALKING = 0.5  # m/s, slower players keep the ball at the foot
AT_FOOT = 0.38  # m ahead of a player who stands
AT_FOOT_TIME, AT_FOOT_SPEED = 0.1, 3.0  # s; m/s at most, relative to the player: how it is put there

# How one runs with the ball, by the speed wanted: at a dribble, at a run, at a sprint, knocking it on in a sprint
DRIBBLING, RUNNING, SPRINTED, KNOCKED_ON = range(4)
DRIBBLE_BELOW = 4.7  # m/s wanted
LONG_AGO = 9.0  # s
LUNGE = 0.12  # s from going for a touch to playing the ball
REST = (0.211, 0.119, 0.11, 0.105)  # s at least from a touch until he goes for the next
PLAYED_AT = (0.586, 0.549, 0.9, 0.979)  # m ahead at which he plays the ball
NEARER = 0.633  # share of that by which he would play it nearer if he stood
SLOWER = 0.4  # m/s, so much faster than the player the ball may be when he goes for it
SLOWING = 2.5  # m/s² of a ball that rolls
LUNGED = (
    0.447,
    0.197,
    -1.426,
    -0.661,
)  # m/s faster while he does, less by the square of the speed's share of what he wants
LUNGED_TURNING = -0.617  # m/s, where he sends it elsewhere
PUSHED_PACE = (1.1, 1.1, 1.1, 1.11)  # a touch gives the ball this times his speed
PUSHED_MORE = (1.541, 2.0, 1.788, 3.555)  # m/s and this more,
PUSHED_MOST = (0.586, 0.368, 0.862, 4.244)  # m/s but at most this more than he wants to run
PUSHED_UP = (0.39, 0.681, 0.86, 1.29)  # m/s upwards
TURNED_BALL, TURNS_BELOW = 1.524, 7.019  # m/s of a ball that is turned back; m/s at which he does that
STOPS_SOON = 1.3  # m/s at which he goes for the first touch of his way back
SLOWED_BALL = 1.2  # m/s less than his speed, where he stops
ASIDE_TIME, ASIDE = 0.55, 2.0  # s in which a touch brings the ball back to his line, m/s at most
FOLLOWS, FOLLOWS_PACE = 0.93, 0.98  # m ahead, share of his speed: a ball that he must follow before he can turn back
BACK_BELOW = -0.3  # cosine of the angle to the wanted direction; below it he has to stop first
TOUCH_PACE = 0.934  # of the speed wanted: the pace that is left when a sprinter has played the ball

# Sprints
ARC_TIME = 0.401  # s after a touch until which a sprint can change direction, from when he goes for it
ARC = 0.677  # rad/s meanwhile
ARC_COS, ARC_SIN = math.cos(ARC * STEP), math.sin(ARC * STEP)
ARC_LEFT = 0.08  # rad by which his turn may be ahead of the ball's
ARC_STRAIGHT = 0.9999  # cosine of an angle that needs no turn
ARC_AHEAD_COS, ARC_AHEAD_SIN = math.cos(0.3 * ARC), math.sin(0.3 * ARC)  # of the touch, for what is still to turn
ARC_PACE, ARC_EASING = 0.908, 2.55  # of the speed wanted, while he turns; m/s² down to it
SPRINT_EFFORT, SPRINT_GAIN = 0.879, 3.21  # share of full effort with which he gathers speed; m/s² at most
EASING = 8.0  # m/s², to a slower gait

# Turns and stops
LAG = (0.4, 0.6, 0.8, 1.0)  # share of full effort in the steps since command and velocity differ
LAG_SPRINT = (0.0, 0.25, 0.9, 1.0)
BRAKE_EARLY = 1.584  # times that share, but at most 1: he brakes before he gathers speed again
BRAKING = 7.055  # m/s², of what leads aside
BRAKING_BACK, BRAKING_LATE, LATE = 14.993, 7.274, 3.88  # m/s² of a run that is to go back; when slower than this, m/s,
BRAKING_ASIDE = 13.356  # and m/s² more where it is not to go straight back, times one plus the cosine
STOPPING, STOPPING_LATE, STOPS_LATE = 13.0, 16.0, 4.0  # m/s²; m/s
FRESH = 12.09  # m/s² in a new direction
OFF, OFF_BACK = 2.293, (2.631, 1.436, 1.968, 1.5)  # m/s at once from standing, and after having stopped to turn


@kernel
def run_with_ball(match, i, speed):
    """Velocity after a step of running with the ball towards the wanted velocity; and decide about the next touch."""
    player, ball = match.players[i], match.ball
    away_x, away_y = ball.x - player.x, ball.y - player.y
    if away_x * away_x + away_y * away_y > TOUCH_REACH * TOUCH_REACH or ball.z > TOUCH_BELOW:
        player.lunge_loss, player.stride = 0.0, abs(player.stride) + STEP
        return run_free(player, speed)
    if player.lunge_loss != 0.0 and speed > 0.0:
        faster = 1.0 + player.lunge_loss / speed
        player.vx *= faster
        player.vy *= faster
        speed += player.lunge_loss
    want = math.sqrt(player.desired_vx * player.desired_vx + player.desired_vy * player.desired_vy)
    gait = gait_of(player, max(want, speed))
    turned = turns_off(player, speed, want)
    lunging = stride_on(ball, player, speed, want, gait)
    vx, vy = player.vx, player.vy
    if not out_runs(ball, player, speed, away_x, away_y):
        vx, vy = steered(ball, player, speed, want)
    player.lunge_loss = 0.0
    speed = math.sqrt(vx * vx + vy * vy)
    if lunging > 0.0 and want > WALKING and speed > 0.0:
        after = min(speed, want * TOUCH_PACE) if gait == SPRINTED and player.stride >= 0.0 else speed
        share, more = min(speed / want, 1.0), LUNGED[gait]
        if turned:
            share, more = min(speed / RUN_SPEED, 1.0), LUNGED_TURNING if gait < SPRINTED else 0.0
        now = after + lunging / STEP * (speed + more * share * share - after)
        player.lunge_loss = after - now
        vx *= now / speed
        vy *= now / speed
    return vx, vy


@kernel
def stride_on(ball, player, speed, want, gait):
    """Let a step of the way from touch to touch pass, and decide about the next; s of the step for which he lunges."""
    if player.stride < 0.0:
        lunging = min(-player.stride, STEP)
        player.stride += STEP
        if abs(player.stride) < SURE:
            player.stride = 0.0
        return lunging
    lunging = STEP - touch_due(ball, player, speed, want, gait)
    if lunging > 0.0:
        player.stride = lunging - LUNGE
        return lunging
    player.stride = min(player.stride + STEP, LONG_AGO)
    return 0.0


@kernel
def out_runs(ball, player, speed, away_x, away_y):
    """Tell whether the ball is still ahead of a sprinter who has just pushed it on: he cannot but follow."""
    if speed < SPRINTING:
        return False
    ahead = (away_x * player.vx + away_y * player.vy) / speed
    along = (ball.vx * player.vx + ball.vy * player.vy) / speed
    wants_back = player.vx * player.desired_vx + player.vy * player.desired_vy < 0.0
    return wants_back and ahead > FOLLOWS and along > FOLLOWS_PACE * speed


@kernel
def turns_off(player, speed, want):
    """Tell whether a player wants to run elsewhere than he does, by more than a step's arc."""
    return player.vx * player.desired_vx + player.vy * player.desired_vy < ARC_COS * speed * want


@kernel
def gait_of(player, want):
    """How a player runs with the ball who wants, or has, this speed."""
    if want < DRIBBLE_BELOW:
        return DRIBBLING
    if want < SPRINTING:
        return RUNNING
    return KNOCKED_ON if player.sprint and player.dribble else SPRINTED


@kernel
def steered(ball, player, speed, want):
    """Velocity after a step with the ball, were he not held back by a touch."""
    dx, dy = player.desired_vx - player.vx, player.desired_vy - player.vy
    if dx * dx + dy * dy < SETTLED * SETTLED:
        player.turning = 0
        return player.desired_vx, player.desired_vy
    along = player.vx * player.desired_vx + player.vy * player.desired_vy
    cosine = along / (speed * want) if speed > 1e-6 and want > 1e-6 else 1.0
    sprinting = speed > SPRINTING - 0.5
    if sprinting and cosine > BACK_BELOW and want > SPRINTING:
        player.turning = 0
        return arc(ball, player, speed, want, cosine)
    if straight(player, speed):
        player.turning = 0
        if speed > RUN_SPEED:
            faster = min(speed + sprint_gain(speed, player.top_speed), want) / speed
            return player.vx * faster, player.vy * faster
        return redirect(player, want, 0.0, 1.0, 0.0, 0.0)
    effort = LAG_SPRINT[min(player.turning, 3)] if sprinting else LAG[min(player.turning, 3)]
    if speed < UNDER_WAY:
        effort = min(player.turning, 1)
    player.turning += 1
    if effort == 0.0:
        return player.vx, player.vy
    if speed < UNDER_WAY and want > UNDER_WAY and player.turning == 2:  # he stood
        start = min(OFF / want, 1.0)
        return player.desired_vx * start, player.desired_vy * start
    if sprinting and cosine > BACK_BELOW:
        return eased(player, speed, want, EASING * effort * STEP)
    if want < 1e-6:
        power = STOPPING if speed > STOPS_LATE else STOPPING_LATE
    elif cosine < BACK_BELOW:
        power = BRAKING_BACK
        if speed < LATE:
            power = BRAKING_LATE * want / RUN_SPEED + BRAKING_ASIDE * (1.0 + cosine)
    else:
        power = BRAKING
    braking = power * min(BRAKE_EARLY * effort, 1.0) * STEP
    off = OFF_BACK[gait_of(player, max(want, speed))]
    return redirect(player, want, braking, effort, FRESH * effort * effort * STEP, off)


@kernel
def sprint_gain(speed, top_speed):
    """Speed in m/s gained in a step of a sprint with the ball."""
    return min(gain(speed, top_speed, SPRINT_EFFORT), SPRINT_GAIN * STEP)


@kernel
def eased(player, speed, want, loss):
    """Velocity after a step in which a sprint with the ball comes down to a slower gait, by `loss` m/s."""
    new = max(speed - loss, want)
    ux, uy = player.vx / speed, player.vy / speed
    if want > 1e-6:
        ux, uy = bent(ux, uy, player.desired_vx / want, player.desired_vy / want, ARC_COS, ARC_SIN)
    return ux * new, uy * new


@kernel
def arc(ball, player, speed, want, cosine):
    """Velocity after a step of a sprint with the ball: it changes direction only around a touch, which costs pace."""
    ux, uy = player.vx / speed, player.vy / speed
    turning = min(player.stride, ARC_TIME) - max(player.stride - STEP, -LUNGE)  # s
    if cosine < ARC_STRAIGHT and turning > 0.0 and not leaves(ball, player, speed):
        new = speed - ARC_EASING * turning if speed > want * ARC_PACE else speed
        angle = ARC * turning
        wx, wy = bent(ux, uy, player.desired_vx / want, player.desired_vy / want, math.cos(angle), math.sin(angle))
        return wx * new, wy * new
    new = min(speed + sprint_gain(speed, player.top_speed), max(want, speed))
    return ux * new, uy * new


@kernel
def leaves(ball, player, speed):
    """Tell whether turning on would take a sprinter away from a ball that he played before he wanted to turn."""
    if player.stride < STEP:
        return False
    side = player.vx * player.desired_vy - player.vy * player.desired_vx
    behind = player.vy * ball.vx - player.vx * ball.vy
    return (behind if side > 0.0 else -behind) > ARC_LEFT * speed * math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy)


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
    wx, wy = player.desired_vx / want, player.desired_vy / want
    speed = math.sqrt(vx * vx + vy * vy)
    if speed > SPRINTING - 0.5 and vx * wx + vy * wy > BACK_BELOW * speed:
        return bent(vx / speed, vy / speed, wx, wy, ARC_AHEAD_COS, ARC_AHEAD_SIN)
    return wx, wy


@kernel
def touch_due(ball, player, speed, want, gait):
    """Seconds until a player goes for his next touch; STEP if he does not in this step."""
    ux, uy = play_direction(player, player.vx, player.vy, want)
    along = ball.vx * ux + ball.vy * uy
    away_x, away_y = ball.x - player.x, ball.y - player.y
    ahead = away_x * ux + away_y * uy
    if want < WALKING:
        return 0.0 if along > 0.5 and (gait < SPRINTED or ahead < PLAYED_AT[gait] + 0.3) else STEP
    pace = player.vx * ux + player.vy * uy
    if pace < BACK_BELOW * speed:
        return 0.0 if speed < STOPS_SOON or (along < 0.5 * TURNED_BALL and speed < TURNS_BELOW) else STEP
    time = max(REST[gait] - player.stride, 0.0)
    if player.touch_wait > STEP or along - SLOWING * time > max(pace, JUMP) + SLOWER:
        return STEP
    closing = pace - along
    share = min(speed / want, 1.0)
    early = ahead - played_at(gait, share) - (closing + LUNGED[gait] * share * share) * LUNGE  # m, when it is played
    if early > 0.0 and speed > UNDER_WAY:
        time = max(time, early / closing if closing > 0.0 else STEP)
    return min(time, STEP)


@kernel
def played_at(gait, share):
    """How far ahead in m he plays the ball: nearer as long as he runs with a share of the speed that he wants."""
    return PLAYED_AT[gait] * (1.0 - NEARER + NEARER * share)


@kernel
def dribble(match):
    """Let the carrier touch the ball if it is his turn to; return whether he did."""
    i = match.carrier
    if i == NOBODY or match.keeper_holding != NOBODY or match.game_mode != NORMAL:
        return False
    player, ball = match.players[i], match.ball
    kicking = match.kicker == i
    if (player.touch_wait > 0.0 and not kicking) or player.down_wait > 0.0 or ball.z > TOUCH_BELOW:
        return False
    away_x, away_y = ball.x - player.x, ball.y - player.y
    if away_x * away_x + away_y * away_y > TOUCH_REACH * TOUCH_REACH:
        return False
    speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
    want = math.sqrt(player.desired_vx * player.desired_vx + player.desired_vy * player.desired_vy)
    if kicking:
        ux, uy = toward(player.aim_x - player.x, player.aim_y - player.y)
        put_at_foot(ball, player, ux, uy)
    elif want < WALKING and speed < WALKING:
        put_at_foot(ball, player, player.facing_x, player.facing_y)
    elif 0.0 <= player.stride < STEP:
        faster = 1.0 + player.lunge_loss / max(speed, WALKING)
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
    """Send the ball where its player, whose run is v but for the touch, wants to go, and back to his line.

    It is played some time into this step, so it begins the step where it must to be there at its end.
    """
    later = STEP - player.stride
    away_x = ball.x - player.x + later * (ball.vx - player.vx)
    away_y = ball.y - player.y + later * (ball.vy - player.vy)
    ux, uy = play_direction(player, vx, vy, want)
    pace, speed = vx * ux + vy * uy, math.sqrt(vx * vx + vy * vy)
    gait = gait_of(player, max(want, speed))
    if want < WALKING:
        fast = max(speed - SLOWED_BALL, 0.0) if speed > STOPS_LATE else 0.0
    elif pace < BACK_BELOW * speed:
        fast = TURNED_BALL
    else:
        short = played_at(gait, min(speed / want, 1.0)) - away_x * ux - away_y * uy
        fast = PUSHED_PACE[gait] * max(pace, JUMP) + PUSHED_MORE[gait]
        fast = min(fast, want + PUSHED_MOST[gait]) + min(max(1.5 * short, 0.0), 0.6)
    across = vy * ux - vx * uy  # to the left of u
    off = away_y * ux - away_x * uy
    aside = (across * abs(across) / (2.0 * BRAKING) - off) / ASIDE_TIME
    aside = min(max(aside, -ASIDE), ASIDE)
    before_x, before_y = ball.vx, ball.vy
    roll(ball, fast * ux - aside * uy, fast * uy + aside * ux)
    ball.x += later * (before_x - ball.vx)
    ball.y += later * (before_y - ball.vy)
    if want > WALKING and pace > 0.0:
        ball.vz = PUSHED_UP[gait]


@kernel
def roll(ball, vx, vy):
    """Let the ball roll on the ground with this velocity."""
    ball.vx, ball.vy, ball.vz = vx, vy, 0.0
    ball.spin_x, ball.spin_y = vx, vy
    ball.z = BALL_RADIUS
