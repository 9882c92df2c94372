"""Running with the ball: body and ball together.

A touch sends the ball ahead, somewhat faster than the carrier; it rolls freely, slows down, and is touched again when
the carrier has caught up. Other players can win the ball between touches. Before a touch the carrier lunges, which is
faster than the run at a dribble, and slower at a sprint. A lunge may begin or end within a step and then acts on a part
of the step. A sprinter changes direction only around a touch, which gives wide arcs. Speeds, distances and rhythms are
fitted to traces of Google Research Football. Read next: `skills.contacts`, where other players meet the ball.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import BALL_RADIUS, NOBODY, NORMAL, RUN_SPEED, STEP
from regista.envs.football.physics.running import (
    BRAKING,
    SETTLED,
    START,
    SURE,
    UNDER_WAY,
    gain,
    lagging,
    redirect,
    run_free,
    straight,
)
from regista.envs.football.physics.vectors import toward
from regista.kernels.jit import kernel

DRIBBLING, RUNNING, SPRINTED, KNOCKED_ON = range(4)  # gaits by desired speed; the last: a sprint with dribble held


class Gaits(NamedTuple):
    """Gaits with the ball: each field has a number for `DRIBBLING`, `RUNNING`, `SPRINTED` and `KNOCKED_ON`."""

    rest: tuple[float, ...] = (0.211, 0.119, 0.11, 0.105)  # s, minimum time from a touch to the next lunge
    played_at: tuple[float, ...] = (0.586, 0.549, 0.9, 0.979)  # m ahead of the body at which the foot plays the ball
    lunge_gain: tuple[float, ...] = (0.447, 0.197, -1.426, -0.661)  # m/s added in a lunge, times (speed / desired)²
    push_pace: tuple[float, ...] = (1.1, 1.1, 1.1, 1.11)  # the ball's speed after a touch: this times the player's,
    push_more: tuple[float, ...] = (1.541, 2.0, 1.788, 3.555)  # plus this in m/s
    push_most: tuple[float, ...] = (0.586, 0.368, 0.862, 4.244)  # at most this in m/s above the desired speed
    push_up: tuple[float, ...] = (0.39, 0.681, 0.86, 1.29)  # the ball's vertical speed after a touch, m/s
    restart: tuple[float, ...] = (2.631, 1.436, 1.968, 1.5)  # m/s, the player's immediate speed after a stop to turn


class Touch(NamedTuple):
    """Touches at any gait."""

    reach: float = 1.15  # m from the body to a ball that the foot can still play
    below: float = 0.9  # m, height of such a ball
    dribble_below: float = 4.7  # m/s; a carrier with a higher desired speed runs
    long_ago: float = 9.0  # s: longer than any stride
    lunge: float = 0.12  # s from the beginning of the lunge to the touch
    lunge_turning: float = -0.617  # m/s added in a lunge that changes the ball's direction
    nearer: float = 0.633  # share of `played_at` by which a standing player would play the ball nearer
    slower: float = 0.4  # m/s by which the ball may be faster than the player at the beginning of a lunge
    slowing: float = 2.5  # m/s², deceleration of a rolling ball
    aside_time: float = 0.55  # s in which a touch brings the ball back to the line of the run
    aside: float = 2.0  # m/s, maximum of that correction
    first_gain: float = 4.5  # m/s², acceleration until the ball can be played again after a first touch
    pace_left: float = 0.934  # share of the desired speed left after a sprinter's touch


class AtFoot(NamedTuple):
    """The ball of a player who stands or is about to kick."""

    walking: float = 0.5  # m/s; slower players keep the ball at the foot
    ahead: float = 0.38  # m ahead of the player
    time: float = 0.1  # s in which the ball is put there
    speed: float = 3.0  # m/s relative to the player, at most


class TurnBack(NamedTuple):
    """Turning back with the ball: the carrier stops it, or has to follow it first."""

    below: float = -0.3  # cosine of the angle to the desired direction, below which a stop comes first
    ball_speed: float = 1.524  # m/s of a ball that is turned back
    from_below: float = 7.019  # m/s up to which the carrier turns the ball back
    stops_soon: float = 1.3  # m/s below which the first touch of the way back begins
    slowed_ball: float = 1.2  # m/s by which the ball is slower than the carrier, at a stop
    follows_ahead: float = 0.93  # m; a ball further ahead must be followed before turning back
    follows_pace: float = 0.98  # speed of such a ball as a share of the carrier's


class Arc(NamedTuple):
    """Sprints: they change direction only around a touch, also during acceleration."""

    above: float = 3.0  # m/s, above which this holds for a turn that began with sprint held
    time: float = 0.401  # s from the lunge to the end of the turn after a touch
    rate: float = 0.677  # rad/s during the turn
    cosine: float = math.cos(rate * STEP)  # cosine of the turn in a full step
    sine: float = math.sin(rate * STEP)
    left: float = 0.08  # rad by which the carrier's turn may be ahead of the ball's
    straight: float = 0.9999  # cosine of an angle that needs no turn
    ahead_cosine: float = math.cos(0.3 * rate)  # cosine by which a touch leads the run, for the remaining turn
    ahead_sine: float = math.sin(0.3 * rate)
    pace: float = 0.908  # share of the desired speed during a turn
    slows: float = 2.55  # m/s², deceleration to that speed
    effort: float = 0.879  # share of full effort in acceleration
    gain: float = 3.21  # m/s², limit of that acceleration
    easing: float = 8.0  # m/s², deceleration to a slower gait


class Brakes(NamedTuple):
    """Turns and stops with the ball."""

    early: float = 1.584  # factor of the share of full effort (clipped to 1) for braking, which precedes acceleration
    aside: float = 7.055  # m/s² of lateral velocity
    back: float = 14.993  # m/s² of a run that is reversed
    back_late: float = 7.274  # m/s², the same at low speed
    slow: float = 3.88  # m/s, limit of that low speed
    back_aside: float = 13.356  # m/s² more for an oblique reversal, times one plus the cosine
    stop: float = 13.0  # m/s² of a run that ends
    stop_late: float = 16.0  # m/s², the same at low speed
    slow_stop: float = 4.0  # m/s, limit of that low speed
    fresh: float = 12.09  # m/s² gained in a new direction
    start: float = 2.293  # m/s, immediate speed from standing


# Fitted to traces of Google Research Football: `lab.benchmarks --suite grf`, family motion.
LAG = (0.4, 0.6, 0.8, 1.0)  # share of full effort in the steps after command and velocity begin to differ
LAG_SPRINT = (0.0, 0.25, 0.9, 1.0)
GAITS, TOUCH, AT_FOOT, TURN_BACK, ARC, BRAKES = Gaits(), Touch(), AtFoot(), TurnBack(), Arc(), Brakes()


@kernel
def run_with_ball(match, i, speed):
    """Return the velocity after a step with the ball towards the desired velocity, and decide on the next touch."""
    player, ball = match.players[i], match.ball
    away_x, away_y = ball.x - player.x, ball.y - player.y
    if away_x * away_x + away_y * away_y > TOUCH.reach * TOUCH.reach or ball.z > TOUCH.below:
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
        if player.brings_down:
            vx, vy = held(player, vx, vy)
    player.lunge_loss = 0.0
    speed = math.sqrt(vx * vx + vy * vy)
    if lunging > 0.0 and want > AT_FOOT.walking and speed > 0.0:
        after = min(speed, want * TOUCH.pace_left) if gait == SPRINTED and player.stride >= 0.0 else speed
        share, more = min(speed / want, 1.0), GAITS.lunge_gain[gait]
        if turned:
            share, more = min(speed / RUN_SPEED, 1.0), TOUCH.lunge_turning if gait < SPRINTED else 0.0
        now = after + lunging / STEP * (speed + more * share * share - after)
        player.lunge_loss = after - now
        vx *= now / speed
        vy *= now / speed
    return vx, vy


@kernel
def held(player, vx, vy):
    """Return the velocity (vx, vy), limited to a small change while the ball rolls on after the first touch."""
    dx, dy = vx - player.vx, vy - player.vy
    share = min(TOUCH.first_gain * STEP / (math.sqrt(dx * dx + dy * dy) + 1e-9), 1.0)
    return player.vx + share * dx, player.vy + share * dy


@kernel
def stride_on(ball, player, speed, want, gait):
    """Advance the stride by a step, and decide on the next touch; return the time in s of the step spent in a lunge."""
    if player.stride < 0.0:
        lunging = min(-player.stride, STEP)
        player.stride += STEP
        if abs(player.stride) < SURE:
            player.stride = 0.0
        return lunging
    lunging = STEP - touch_due(ball, player, speed, want, gait)
    if lunging > 0.0:
        player.stride = lunging - TOUCH.lunge
        return lunging
    player.stride = min(player.stride + STEP, TOUCH.long_ago)
    return 0.0


@kernel
def out_runs(ball, player, speed, away_x, away_y):
    """Return whether a ball after a touch is still so far ahead that the sprinter must follow it."""
    if speed < BRAKING.sprinting:
        return False
    ahead = (away_x * player.vx + away_y * player.vy) / speed
    along = (ball.vx * player.vx + ball.vy * player.vy) / speed
    wants_back = player.vx * player.desired_vx + player.vy * player.desired_vy < 0.0
    return wants_back and ahead > TURN_BACK.follows_ahead and along > TURN_BACK.follows_pace * speed


@kernel
def turns_off(player, speed, want):
    """Return whether the desired change of direction exceeds the arc of one step."""
    return player.vx * player.desired_vx + player.vy * player.desired_vy < ARC.cosine * speed * want


@kernel
def gait_of(player, want):
    """Return the gait with the ball for a desired or actual speed."""
    if want < TOUCH.dribble_below:
        return DRIBBLING
    if want < BRAKING.sprinting:
        return RUNNING
    return KNOCKED_ON if player.sprint and player.dribble else SPRINTED


@kernel
def steered(ball, player, speed, want):
    """Return the velocity after a step with the ball, without the constraint of a touch."""
    dx, dy = player.desired_vx - player.vx, player.desired_vy - player.vy
    if dx * dx + dy * dy < SETTLED * SETTLED:
        player.turning = 0
        return player.desired_vx, player.desired_vy
    along = player.vx * player.desired_vx + player.vy * player.desired_vy
    cosine = along / (speed * want) if speed > 1e-6 and want > 1e-6 else 1.0
    sprinting = speed > BRAKING.sprinting - 0.5 or (player.turns_wide and speed > ARC.above)
    if sprinting and cosine > TURN_BACK.below and want > BRAKING.sprinting:
        player.turning = 0
        return arc(ball, player, speed, want, cosine)
    if straight(player, speed):
        player.turning = 0
        if speed > RUN_SPEED:
            faster = min(speed + sprint_gain(speed, player.top_speed), want) / speed
            return player.vx * faster, player.vy * faster
        return redirect(player, want, 0.0, 1.0, 0.0, 0.0)
    effort = lagging((LAG_SPRINT if sprinting else LAG)[min(player.turning, 3)], player.start_lag)
    if speed < UNDER_WAY:
        effort = min(player.turning, 1)
    player.turning += 1
    if effort == 0.0:
        return player.vx, player.vy
    if speed < UNDER_WAY and want > UNDER_WAY and player.turning == 2:  # from standing
        start = min(BRAKES.start * (2.0 - player.start_lag) / want, 1.0)  # a later start within the step
        return player.desired_vx * start, player.desired_vy * start
    if sprinting and cosine > TURN_BACK.below:
        return eased(player, speed, want, ARC.easing * effort * STEP)
    if want < 1e-6:
        power = BRAKES.stop if speed > BRAKES.slow_stop else BRAKES.stop_late
    elif cosine < TURN_BACK.below:
        power = BRAKES.back
        if speed < BRAKES.slow:
            power = BRAKES.back_late * want / RUN_SPEED + BRAKES.back_aside * (1.0 + cosine)
    else:
        power = BRAKES.aside
    braking = power * min(BRAKES.early * effort, 1.0) * STEP
    off = GAITS.restart[gait_of(player, max(want, speed))]
    return redirect(player, want, braking, effort, BRAKES.fresh * effort * effort * STEP, off)


@kernel
def sprint_gain(speed, top_speed):
    """Return the speed in m/s gained in a step of a sprint with the ball."""
    return min(gain(speed, top_speed, ARC.effort), ARC.gain * STEP)


@kernel
def eased(player, speed, want, loss):
    """Return the velocity after a step in which a sprint with the ball slows down to another gait, by `loss` m/s."""
    new = max(speed - loss, want)
    ux, uy = player.vx / speed, player.vy / speed
    if want > 1e-6:
        ux, uy = bent(ux, uy, player.desired_vx / want, player.desired_vy / want, ARC.cosine, ARC.sine)
    return ux * new, uy * new


@kernel
def arc(ball, player, speed, want, cosine):
    """Return the velocity after a sprint step with the ball; turns happen only around a touch and cost speed."""
    ux, uy = player.vx / speed, player.vy / speed
    turning = min(player.stride, ARC.time) - max(player.stride - STEP, -TOUCH.lunge)  # s in which the sprinter may turn
    if cosine < ARC.straight and turning > 0.0 and not ball_escapes(ball, player, speed):
        kept = want * ARC.pace
        new = speed - ARC.slows * turning if speed > kept else min(speed + sprint_gain(speed, player.top_speed), kept)
        angle = ARC.rate * turning
        wx, wy = bent(ux, uy, player.desired_vx / want, player.desired_vy / want, math.cos(angle), math.sin(angle))
        return wx * new, wy * new
    more = gain(speed, player.top_speed, 1.0) if speed < RUN_SPEED else sprint_gain(speed, player.top_speed)
    new = min(speed + more, max(want, speed))
    return ux * new, uy * new


@kernel
def ball_escapes(ball, player, speed):
    """Return whether further turning would separate a sprinter from a ball that was played before the turn."""
    if player.stride < STEP:
        return False
    side = player.vx * player.desired_vy - player.vy * player.desired_vx
    behind = player.vy * ball.vx - player.vx * ball.vy
    return (behind if side > 0.0 else -behind) > ARC.left * speed * math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy)


@kernel
def bent(ux, uy, wx, wy, cosine, sine):
    """Turn the unit vector u towards the unit vector w, by at most the angle with this cosine and sine."""
    if ux * wx + uy * wy >= cosine:
        return wx, wy
    if ux * wy - uy * wx < 0.0:
        sine = -sine
    return ux * cosine - uy * sine, ux * sine + uy * cosine


@kernel
def play_direction(player, vx, vy, want):
    """Return the desired direction of the ball as a unit vector; in a sprint it is limited to the vicinity of the run
    v.
    """
    if want < AT_FOOT.walking:
        return player.facing_x, player.facing_y
    wx, wy = player.desired_vx / want, player.desired_vy / want
    speed = math.sqrt(vx * vx + vy * vy)
    if speed > BRAKING.sprinting - 0.5 and vx * wx + vy * wy > TURN_BACK.below * speed:
        return bent(vx / speed, vy / speed, wx, wy, ARC.ahead_cosine, ARC.ahead_sine)
    return wx, wy


@kernel
def touch_due(ball, player, speed, want, gait):
    """Return the seconds until the lunge of the next touch; STEP if it is not in this step."""
    ux, uy = play_direction(player, player.vx, player.vy, want)
    along = ball.vx * ux + ball.vy * uy
    away_x, away_y = ball.x - player.x, ball.y - player.y
    ahead = away_x * ux + away_y * uy
    if want < AT_FOOT.walking:
        return 0.0 if along > 0.5 and (gait < SPRINTED or ahead < GAITS.played_at[gait] + 0.3) else STEP
    pace = player.vx * ux + player.vy * uy
    if pace < TURN_BACK.below * speed:
        turned = along < 0.5 * TURN_BACK.ball_speed and speed < TURN_BACK.from_below
        return 0.0 if speed < TURN_BACK.stops_soon or turned else STEP
    time = max(GAITS.rest[gait] - player.stride, 0.0)
    if player.touch_wait > STEP or along - TOUCH.slowing * time > max(pace, START.jump) + TOUCH.slower:
        return STEP
    closing = pace - along
    share = min(speed / want, 1.0)
    lunge_way = (closing + GAITS.lunge_gain[gait] * share * share) * TOUCH.lunge  # m
    early = ahead - played_at(gait, share) - lunge_way  # m of run left before the ball can be played
    if early > 0.0 and speed > UNDER_WAY:
        time = max(time, early / closing if closing > 0.0 else STEP)
    return min(time, STEP)


@kernel
def played_at(gait, share):
    """Return the distance ahead in m at which the ball is played: nearer at a smaller share of the desired speed."""
    return GAITS.played_at[gait] * (1.0 - TOUCH.nearer + TOUCH.nearer * share)


@kernel
def dribble(match):
    """Let the carrier touch the ball if a touch is due; return whether it was touched."""
    i = match.carrier
    if i == NOBODY or match.keeper_holding != NOBODY or match.game_mode != NORMAL:
        return False
    player, ball = match.players[i], match.ball
    kicking = match.kicker == i
    if (player.touch_wait > 0.0 and not kicking) or player.down_wait > 0.0 or ball.z > TOUCH.below:
        return False
    away_x, away_y = ball.x - player.x, ball.y - player.y
    if away_x * away_x + away_y * away_y > TOUCH.reach * TOUCH.reach:
        return False
    speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
    want = math.sqrt(player.desired_vx * player.desired_vx + player.desired_vy * player.desired_vy)
    if kicking:
        ux, uy = toward(player.aim_x - player.x, player.aim_y - player.y)
        put_at_foot(ball, player, ux, uy)
    elif want < AT_FOOT.walking and speed < AT_FOOT.walking:
        put_at_foot(ball, player, player.facing_x, player.facing_y)
    elif 0.0 <= player.stride < STEP:
        faster = 1.0 + player.lunge_loss / max(speed, AT_FOOT.walking)
        push_on(ball, player, player.vx * faster, player.vy * faster, want)
    else:
        return False
    return True


@kernel
def put_at_foot(ball, player, ux, uy):
    """Play the ball to the foot of a player who stands, or who is about to kick it along u."""
    push_x = (player.x + AT_FOOT.ahead * ux - ball.x) / AT_FOOT.time
    push_y = (player.y + AT_FOOT.ahead * uy - ball.y) / AT_FOOT.time
    push = math.sqrt(push_x * push_x + push_y * push_y)
    if push > AT_FOOT.speed:
        push_x, push_y = push_x / push * AT_FOOT.speed, push_y / push * AT_FOOT.speed
    roll(ball, player.vx + push_x, player.vy + push_y)


@kernel
def push_on(ball, player, vx, vy, want):
    """Send the ball in the carrier's desired direction and back to the line of the run; v is the run without the touch.

    The touch happens within this step, so the ball's position at the start is adjusted to be correct at the end.
    """
    later = STEP - player.stride
    away_x = ball.x - player.x + later * (ball.vx - player.vx)
    away_y = ball.y - player.y + later * (ball.vy - player.vy)
    ux, uy = play_direction(player, vx, vy, want)
    pace, speed = vx * ux + vy * uy, math.sqrt(vx * vx + vy * vy)
    gait = gait_of(player, max(want, speed))
    if want < AT_FOOT.walking:
        fast = max(speed - TURN_BACK.slowed_ball, 0.0) if speed > BRAKES.slow_stop else 0.0
    elif pace < TURN_BACK.below * speed:
        fast = TURN_BACK.ball_speed
    else:
        short = played_at(gait, min(speed / want, 1.0)) - away_x * ux - away_y * uy
        fast = GAITS.push_pace[gait] * max(pace, START.jump) + GAITS.push_more[gait]
        fast = min(fast, want + GAITS.push_most[gait]) + min(max(1.5 * short, 0.0), 0.6)
    across = vy * ux - vx * uy  # to the left of u
    off = away_y * ux - away_x * uy
    aside = (across * abs(across) / (2.0 * BRAKES.aside) - off) / TOUCH.aside_time
    aside = min(max(aside, -TOUCH.aside), TOUCH.aside)
    before_x, before_y = ball.vx, ball.vy
    roll(ball, fast * ux - aside * uy, fast * uy + aside * ux)
    ball.x += later * (before_x - ball.vx)
    ball.y += later * (before_y - ball.vy)
    if want > AT_FOOT.walking and pace > 0.0:
        ball.vz = GAITS.push_up[gait]


@kernel
def roll(ball, vx, vy):
    """Let the ball roll on the ground with this velocity."""
    ball.vx, ball.vy, ball.vz = vx, vy, 0.0
    ball.spin_x, ball.spin_y = vx, vy
    ball.z = BALL_RADIUS
