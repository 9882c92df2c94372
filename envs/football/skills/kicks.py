"""Kicks: when the leg swings, how long it takes, and what happens when the ball leaves the foot.

Fitted to delays measured of Google Research Football, whose animations quantise them. Read next: `skills.shots`,
`skills.passes`.
"""

from __future__ import annotations

import math

from envs.football.constants import (
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
from envs.football.physics.possession import forget_kick, lose_ball
from envs.football.physics.vectors import apart, length
from envs.football.rules.offside import whistled
from envs.football.skills.passes import aim_pass, play_pass
from envs.football.skills.saves import foresee_shot
from envs.football.skills.shots import aim_shot, angle_between, strike
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

KICK_REACH = 1.2  # m from the body to the ball when the leg swings
SWING_PATIENCE = -0.6  # s, `kick_wait` at which a kick that never met the ball is given up
AFTER_KICK = 0.45  # s until the kicker can touch the ball again

# Gauge: how long the button was held, 0 to 1
HELD_STEP, HELD_LEAST, HELD_RANGE = 0.1, 0.06, 0.94  # s
SHOT_GAUGE_POWER = 0.6

# Seconds from the command to the contact: from the stand, when starting to run, on the run; and by how much more
# the angle from the run to the kick delays it, in full from so many rad
SWING_STANDING, SWING_STARTING, SWING_RUNNING = 0.26, 0.25, 0.235
ACROSS, ACROSS_STANDING, ACROSS_STARTING, ACROSS_RUNNING = 0.16, 0.5 * math.pi, 0.3 * math.pi, 0.52 * math.pi
ROUND_FROM, ROUND_BY = 0.5 * math.pi, 0.62 * math.pi  # turning round, in part and in full
ROUND, ROUND_RUNNING = 0.3, 0.05
GROUND_PASS_LATER = 0.1  # a leg swings wider for a pass along the ground ..
HIGH_NEAR, HIGH_NEAR_LATER = 8.0, 0.1  # .. or for a chip over less than so many m
PASS_ACROSS = 0.25  # share of a shot's delay across the run that a pass has
PASS_ROUND, PASS_BEHIND = 0.2, 0.76 * math.pi  # s more when it goes so many rad behind
RUNNING_FROM = 3.5  # m/s
SPRINTING_FROM, SPRINT_LATER, SPRINT_SPREAD = 5.6, 0.12, 0.2  # m/s; catching up with the ball takes so much more, s
FROM_RUN_UP = 0.06  # s left of the swing for who has asked for a pass on his way to the ball: he swings as he arrives
SPREAD = 0.04  # s either way, the phase of the stride
STANDS = 1.0  # m/s, who is slower kicks from where he looks

# Kicks behind the body: he turns on the spot and kicks from short of the kick's direction
BEHIND = 0.74 * math.pi  # rad from run to kick
SHORT_OF = 0.35  # rad
TURNED_SPEED = 0.8  # m/s left

# A pass is aimed again when it leaves the foot, as far off the first aim as this
AIM_AGAIN = 0.15 * math.pi


@kernel
def swing_legs(match):
    """Start the swing of whoever is to kick and has the ball."""
    i = match.carrier
    if i == NOBODY or match.kicker != NOBODY:
        return
    player = match.players[i]
    if not player.kick_ready or player.kick == 0 or apart(match.ball, player) > KICK_REACH:
        return
    if not player.is_aimed:
        aim(match, i)
    player.kick_wait = swing_time(match, player)
    if match.carry_age <= 1 and not player.is_aimed and player.kick != SHOT:
        run_up = STEP * (KICK_PATIENCE - 1 - player.kick_patience)
        player.kick_wait = max(player.kick_wait - run_up, FROM_RUN_UP)
    match.kicker = i


@kernel
def heading(player):
    """Direction as a unit vector of the run, or else of the run that is wanted, or where he looks; speed in m/s."""
    speed = length(player.vx, player.vy)
    if speed > STANDS:
        return player.vx / speed, player.vy / speed, speed
    if player.direction > 0:
        return DIRECTION_X[player.direction], DIRECTION_Y[player.direction], speed
    return player.facing_x, player.facing_y, speed


@kernel
def swing_time(match, player):
    """Seconds from the command to the contact: longer across the run, round the body, and at a sprint."""
    hx, hy, speed = heading(player)
    dx, dy = player.aim_x - player.x, player.aim_y - player.y
    starting = speed > STANDS or player.direction > 0
    angle = abs(angle_between(hx, hy, dx, dy))
    if player.kick != SHOT:
        angle = max(angle, abs(angle_between(match.ball.x - player.x, match.ball.y - player.y, dx, dy)))
    time = delay(player.kick, angle, speed, starting, length(dx, dy))
    spread = SPREAD
    if speed > SPRINTING_FROM:
        time, spread = time + SPRINT_LATER, SPRINT_SPREAD
    return time + spread * (2.0 * uniform(match) - 1.0)


@kernel
def delay(kick, angle, speed, starting, distance):
    """Mean seconds from the command to the contact of a kick over `distance`, `angle` rad off the run."""
    turn = ROUND * min(max((angle - ROUND_FROM) / (ROUND_BY - ROUND_FROM), 0.0), 1.0)
    if speed > RUNNING_FROM:
        time, full, turn = SWING_RUNNING, ACROSS_RUNNING, ROUND_RUNNING if angle > BEHIND else 0.0
    elif starting:
        time, full = SWING_STARTING, ACROSS_STARTING
    else:
        time, full = SWING_STANDING, ACROSS_STANDING
    side = min(angle / full, 1.0)
    across = ACROSS * side * side * (3.0 - 2.0 * side)
    if kick == SHOT:
        return time + across + turn
    if kick != HIGH_PASS:
        time += GROUND_PASS_LATER
    elif distance < HIGH_NEAR:
        time += HIGH_NEAR_LATER
    return time + PASS_ACROSS * across + (PASS_ROUND if angle > PASS_BEHIND else 0.0)


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
def gauge(held):
    """How full the gauge is, 0 to 1, after so many steps of holding the button."""
    return min(max((HELD_STEP * held - HELD_LEAST) / HELD_RANGE, 0.0), 1.0)


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
        aim_shot(match, player, ux, uy)
    else:
        aim_pass(match, i, ux, uy, gauge(player.kick_held))


@kernel
def aim_again(match, i):
    """Correct a pass for what has moved since the leg began to swing, unless it would go quite another way."""
    player, ball = match.players[i], match.ball
    x, y, mate = player.aim_x, player.aim_y, player.kick_mate
    aim(match, i)
    off = angle_between(x - ball.x, y - ball.y, player.aim_x - ball.x, player.aim_y - ball.y)
    if abs(off) > AIM_AGAIN:
        player.aim_x, player.aim_y, player.kick_mate = x, y, mate


@kernel
def leave_foot(match, i):
    """Send the ball off player i's foot."""
    player, ball = match.players[i], match.ball
    if not player.is_aimed and player.kick != SHOT:
        aim_again(match, i)
    dx, dy = player.aim_x - ball.x, player.aim_y - ball.y
    distance = length(dx, dy)
    if distance < 0.1:  # to his own feet: straight ahead
        dx, dy, distance = 0.1 * player.facing_x, 0.1 * player.facing_y, 0.1
    ux, uy = dx / distance, dy / distance
    turn_body(match, player, ux, uy)
    ball.z = max(ball.z, BALL_RADIUS)
    if player.kick == SHOT:
        strike(match, player, ux, uy, max(gauge(player.kick_held) ** SHOT_GAUGE_POWER, 0.01))
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
def kick_first_time(match, i):
    """Let player i, who has asked for a kick, play a free ball without stopping it: a volley or a header."""
    if whistled(match, i):
        return
    lose_ball(match)
    if not match.players[i].is_aimed:
        aim(match, i)
    leave_foot(match, i)


@kernel
def turn_body(match, player, ux, uy):
    """Bring a body that kicks behind itself round to just short of the kick along (ux, uy)."""
    hx, hy, speed = heading(player)
    off = angle_between(hx, hy, ux, uy)
    if abs(off) < BEHIND:
        return
    if math.pi - abs(off) < 0.02:  # straight behind: either way round
        off = math.pi if uniform(match) < 0.5 else -math.pi
    cosine, sine = math.cos(SHORT_OF), math.copysign(math.sin(SHORT_OF), -off)
    player.facing_x, player.facing_y = ux * cosine - uy * sine, ux * sine + uy * cosine
    speed = min(speed, TURNED_SPEED)
    player.vx, player.vy = speed * player.facing_x, speed * player.facing_y
