"""Kicks: when the leg swings, how long the swing takes, and how the ball leaves the foot.

Fitted to delays measured in Google Research Football, whose animations quantize them. Read next: `skills.shots`,
`skills.passes`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import (
    BALL_RADIUS,
    DIRECTION_X,
    DIRECTION_Y,
    DT,
    HIGH_PASS,
    KICK_PATIENCE,
    NOBODY,
    SHOT,
    STEP,
)
from regista.envs.football.physics.possession import forget_kick, lose_ball
from regista.envs.football.physics.vectors import apart, length, toward
from regista.envs.football.rules.offside import whistled
from regista.envs.football.skills.passes import aim_pass, play_pass
from regista.envs.football.skills.saves import foresee_shot
from regista.envs.football.skills.shots import aim_shot, angle_between, strike
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Gauge(NamedTuple):
    """How full the gauge is, 0 to 1, depending on how long the button was held."""

    step: float = 0.1  # s
    least: float = 0.06  # s
    range: float = 0.94  # s
    shot_power: float = 0.6


class Swing(NamedTuple):
    """The time in s from the command to the contact, and its delays."""

    standing: float = 0.26  # s, of a standing player
    starting: float = 0.25  # s, of a player who starts to run
    running: float = 0.235  # s, of a runner
    across: float = 0.16  # s more for a kick across the run, in full at these angles in rad:
    across_standing: float = 0.5 * math.pi
    across_starting: float = 0.3 * math.pi
    across_running: float = 0.52 * math.pi
    round_from: float = 0.5 * math.pi  # rad, from which on the player must turn round,
    round_by: float = 0.62 * math.pi  # rad, and at which in full
    round: float = 0.3  # s more for turning round
    round_running: float = 0.05  # s more for turning round on the run
    ground_pass: float = 0.1  # s more for a ground pass, since the leg swings wider
    high_near: float = 8.0  # m; a high pass shorter than this is a chip
    high_near_later: float = 0.1  # s more for a chip
    pass_across: float = 0.25  # share of the delay across the run that applies to passes
    pass_round: float = 0.2  # s more for a pass backwards
    pass_behind: float = 0.76 * math.pi  # rad, from which on a pass goes backwards
    running_from: float = 3.3  # m/s
    sprinting_from: float = 5.6  # m/s
    sprint: float = 0.12  # s more, to catch up with the ball
    sprint_spread: float = 0.2  # s either way, for a sprinter
    spread: float = 0.04  # s either way, for the phase of the stride
    meant: float = 0.28  # s before the contact; later, the receiver is fixed, and a new direction only turns the pass
    from_run_up: float = 0.06  # s, minimum swing after a request on the way to the ball: it begins on arrival
    patience: float = -0.6  # s, `kick_wait` at which a kick that did not meet the ball is canceled


class Behind(NamedTuple):
    """Kicks behind the body: the player turns on the spot to just short of the kick's direction."""

    angle: float = 0.74 * math.pi  # rad from run to kick
    short_of: float = 0.35  # rad by which the turn stops short of the kick's direction
    speed: float = 0.8  # m/s left of the run


# Fitted to delays measured in Google Research Football, whose animations quantize them: `lab.benchmarks --suite
# grf`, families passes and shots.
GAUGE, SWING, BEHIND = Gauge(), Swing(), Behind()
KICK_REACH = 1.2  # m from the body to the ball when the leg swings
FAR = 1e4  # m, beyond which a target only defines a direction
AFTER_KICK = 0.45  # s until the kicker can touch the ball again
STANDS = 1.0  # m/s, below which a player kicks along the facing direction
AIM_AGAIN = 0.15 * math.pi  # rad: a pass is aimed again when it leaves the foot, up to this angle from the first target
AIM_TOWARD = 2.0 * AIM_AGAIN  # rad: up to this angle it is turned by `AIM_AGAIN`; beyond, it keeps its first target


@kernel
def swing_legs(match):
    """Start the swing of the carrier if a kick is due."""
    i = match.carrier
    if match.kicker != NOBODY:
        if match.kicker == i:
            mean_pass(match, i)
        return
    if i == NOBODY:
        return
    player = match.players[i]
    if not player.kick_ready or player.kick == 0 or apart(match.ball, player) > KICK_REACH:
        return
    if player.brings_down and player.stance_wait > 0.0:  # the player stops the ball first
        return
    if not player.is_aimed:
        aim(match, i)
    player.kick_wait = swing_time(match, player)
    if player.kick == SHOT:
        keep_direction(player)
    if match.carry_age <= 1 and not player.is_aimed:
        run_up = STEP * (KICK_PATIENCE - 1 - player.kick_patience)
        player.kick_wait = max(player.kick_wait - run_up, SWING.from_run_up)
    match.kicker = i


@kernel
def mean_pass(match, i):
    """Let the held direction choose the receiver of player i's pass during the swing, until `SWING.meant` s are left.

    After that, the pass keeps its direction, independent of the foot's further movement.
    """
    player = match.players[i]
    if player.kick == SHOT or player.is_aimed:
        return
    if player.kick_wait > SWING.meant:
        aim(match, i)
    else:
        player.aim_x, player.aim_y = player.aim_x + STEP * player.vx, player.aim_y + STEP * player.vy


@kernel
def keep_direction(player):
    """Let a shot keep its direction, independent of the foot's further movement; only passes are aimed again."""
    ux, uy = toward(player.aim_x - player.x, player.aim_y - player.y)
    player.aim_x, player.aim_y = player.x + FAR * ux, player.y + FAR * uy


@kernel
def heading(player):
    """Return the direction (the run, else the desired run, else the facing) as a unit vector, and the speed in m/s."""
    speed = length(player.vx, player.vy)
    if speed > STANDS:
        return player.vx / speed, player.vy / speed, speed
    if player.direction > 0:
        return DIRECTION_X[player.direction], DIRECTION_Y[player.direction], speed
    return player.facing_x, player.facing_y, speed


@kernel
def swing_time(match, player):
    """Return the seconds from the command to the contact: longer across the run, round the body, and at a sprint."""
    hx, hy, speed = heading(player)
    dx, dy = player.aim_x - player.x, player.aim_y - player.y
    starting = speed > STANDS or player.direction > 0
    angle = abs(angle_between(hx, hy, dx, dy))
    if player.kick != SHOT:
        angle = max(angle, abs(angle_between(match.ball.x - player.x, match.ball.y - player.y, dx, dy)))
    time = delay(player.kick, angle, speed, starting, length(dx, dy))
    spread = SWING.spread
    if speed > SWING.sprinting_from:
        time, spread = time + SWING.sprint, SWING.sprint_spread
    return time + spread * (2.0 * uniform(match) - 1.0)


@kernel
def delay(kick, angle, speed, starting, distance):
    """Return the mean seconds from the command to the contact of a kick over `distance`, `angle` rad off the run."""
    turn = SWING.round * min(max((angle - SWING.round_from) / (SWING.round_by - SWING.round_from), 0.0), 1.0)
    if speed > SWING.running_from:
        time, full, turn = SWING.running, SWING.across_running, SWING.round_running if angle > BEHIND.angle else 0.0
    elif starting:
        time, full = SWING.starting, SWING.across_starting
    else:
        time, full = SWING.standing, SWING.across_standing
    side = min(angle / full, 1.0)
    across = SWING.across * side * side * (3.0 - 2.0 * side)
    if kick == SHOT:
        return time + across + turn
    if kick != HIGH_PASS:
        time += SWING.ground_pass
    elif distance < SWING.high_near:
        time += SWING.high_near_later
    return time + SWING.pass_across * across + (SWING.pass_round if angle > SWING.pass_behind else 0.0)


@kernel
def swing_frame(match):
    """Advance the kicker's swing by a frame; return whether the foot meets the ball now."""
    i = match.kicker
    player = match.players[i]
    player.kick_wait -= DT
    if player.kick_wait > 0.0:
        return False
    if match.carrier != i or player.kick_wait < SWING.patience:
        forget_kick(player)
        match.kicker = NOBODY
        return False
    return not apart(match.ball, player) > KICK_REACH


@kernel
def gauge(held):
    """Return how full the gauge is, 0 to 1, after holding the button for `held` steps."""
    return min(max((GAUGE.step * held - GAUGE.least) / GAUGE.range, 0.0), 1.0)


@kernel
def input_direction(player):
    """Return the direction that aims a kick: the held one, or the player's facing."""
    if player.direction > 0:
        return DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    return player.facing_x, player.facing_y


@kernel
def aim(match, i):
    """Set the target of player i's kick."""
    player = match.players[i]
    ux, uy = input_direction(player)
    if player.kick == SHOT:
        aim_shot(match, player, ux, uy)
    else:
        aim_pass(match, i, ux, uy, gauge(player.kick_held))


@kernel
def aim_again(match, i):
    """Correct a pass for movements since the swing began, and for the direction held now.

    The pass turns as far as a swinging foot can. If the direction would change too much, the pass keeps its target.
    """
    player, ball = match.players[i], match.ball
    x, y, mate = player.aim_x - ball.x, player.aim_y - ball.y, player.kick_mate
    aim(match, i)
    new_x, new_y = player.aim_x - ball.x, player.aim_y - ball.y
    off = angle_between(x, y, new_x, new_y)
    if abs(off) <= AIM_AGAIN:
        return
    if abs(off) < AIM_TOWARD:
        share, distance = AIM_AGAIN / abs(off), length(x, y)
        size = (1.0 + share * (length(new_x, new_y) / distance - 1.0)) if distance > 0.0 else 1.0
        cosine, sine = size * math.cos(AIM_AGAIN), math.copysign(size * math.sin(AIM_AGAIN), off)
        x, y, mate = x * cosine - y * sine, x * sine + y * cosine, player.kick_mate
    player.aim_x, player.aim_y, player.kick_mate = ball.x + x, ball.y + y, mate


@kernel
def leave_foot(match, i, clean):
    """Send the ball off player i's foot; `clean` in (0, 1] is the share of the kick in its velocity."""
    player, ball = match.players[i], match.ball
    vx, vy, vz = ball.vx, ball.vy, ball.vz
    if not player.is_aimed and player.kick != SHOT:
        aim_again(match, i)
    dx, dy = player.aim_x - ball.x, player.aim_y - ball.y
    distance = length(dx, dy)
    if distance < 0.1:  # to the own feet: play it straight ahead
        dx, dy, distance = 0.1 * player.facing_x, 0.1 * player.facing_y, 0.1
    ux, uy = dx / distance, dy / distance
    turn_body(match, player, ux, uy)
    ball.z = max(ball.z, BALL_RADIUS)
    if player.kick == SHOT:
        strike(match, player, ux, uy, max(gauge(player.kick_held) ** GAUGE.shot_power, 0.01))
    else:
        play_pass(match, player, ux, uy, distance)
    if clean < 1.0:
        ball.vx, ball.vy = clean * ball.vx + (1.0 - clean) * vx, clean * ball.vy + (1.0 - clean) * vy
        ball.vz = clean * ball.vz + (1.0 - clean) * vz
    player.facing_x, player.facing_y = ux, uy
    player.touch_wait = AFTER_KICK
    match.receiver = player.kick_mate
    forget_kick(player)
    lose_ball(match)
    match.last_touch = i
    foresee_shot(match, player.team)


@kernel
def kick_first_time(match, i, clean):
    """Let player i, who has requested a kick, play a ball first-time, as a volley or a header, as `leave_foot` does."""
    if whistled(match, i):
        return
    lose_ball(match)
    if not match.players[i].is_aimed:
        aim(match, i)
    leave_foot(match, i, clean)


@kernel
def turn_body(match, player, ux, uy):
    """Turn a body that kicks behind itself to just short of the kick along (ux, uy)."""
    hx, hy, speed = heading(player)
    off = angle_between(hx, hy, ux, uy)
    if abs(off) < BEHIND.angle:
        return
    if math.pi - abs(off) < 0.02:  # straight behind, where both ways round are equal
        off = math.pi if uniform(match) < 0.5 else -math.pi
    cosine, sine = math.cos(BEHIND.short_of), math.copysign(math.sin(BEHIND.short_of), -off)
    player.facing_x, player.facing_y = ux * cosine - uy * sine, ux * sine + uy * cosine
    speed = min(speed, BEHIND.speed)
    player.vx, player.vy = speed * player.facing_x, speed * player.facing_y
