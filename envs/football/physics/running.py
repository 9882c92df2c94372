"""How a body answers a command: from the velocity that it has to the one that it wants, step by step.

It finishes its stride first, brakes hard what leads elsewhere, is off at once with a jump, and then gathers speed.
The numbers are fitted to traces of Google Research Football. Read next: `physics.dribble`, how that changes with the
ball at the feet.
"""

from __future__ import annotations

import math

from envs.football.constants import RUN_SPEED, STEP
from scenic_lite.kernels.jit import kernel

# Speeds often land exactly where one rule ends and the next begins, such as 0.1 off the command or 0.5 after braking:
# rounding, which differs between directions, must not decide which of them holds.
SURE = 1e-6  # m/s
SETTLED = 0.1 + SURE  # m/s, command and velocity this close are the same
UNDER_WAY = 0.5 - SURE  # m/s
# Share of full effort in the steps since command and velocity differ: the body's lag.
LAG_FROM_REST = (0.6, 1.0, 1.0, 1.0)
LAG_WALKING = (0.1, 0.58, 1.0, 1.0)
LAG_RUNNING = (0.0, 0.0, 0.25, 1.0)
LAG_SPRINTING = (0.0, 0.15, 0.75, 1.0)
SLOW, WALKING, SPRINTING = 2.7, 3.8, 6.0  # m/s
BRAKING = 30.0  # m/s²
JUMP, JUMP_GAIN = 2.0, 13.0  # m/s at once from standing; m/s² while that is not over, and into a new direction
TURN_START = 1.1  # m/s at once after having stopped to turn
ACCELERATION = 8.5  # m/s² from there to RUN_SPEED
# The gait changes around RUN_SPEED, which takes him longer
CHANGES_FROM, CHANGES_TO, ACCELERATION_CHANGING = 4.9, 5.1, 2.1  # m/s; m/s²
ACCELERATION_SPRINT, ACCELERATION_TIME = 4.9, 0.39  # m/s² and s, from there on: approach to top speed


@kernel
def run_free(player, speed):
    """Velocity after a step of running without the ball towards the wanted velocity."""
    dx, dy = player.desired_vx - player.vx, player.desired_vy - player.vy
    if dx * dx + dy * dy < SETTLED * SETTLED:
        player.turning = 0
        return player.desired_vx, player.desired_vy
    if straight(player, speed):
        player.turning = 0
        effort = 1.0
    else:
        effort = effort_now(player.turning, speed)
        player.turning += 1
    if effort == 0.0:
        return player.vx, player.vy
    want = math.sqrt(player.desired_vx * player.desired_vx + player.desired_vy * player.desired_vy)
    fresh = JUMP_GAIN * max(RUN_SPEED / max(want, 1.0), 1.0) * effort * STEP
    return redirect(player, want, BRAKING * effort * STEP, effort, fresh, TURN_START)


@kernel
def straight(player, speed):
    """Tell whether a player already runs where he wants to run, only not yet as fast: there is nothing to answer."""
    if speed < UNDER_WAY:
        return False
    along = player.vx * player.desired_vx + player.vy * player.desired_vy
    across = player.vx * player.desired_vy - player.vy * player.desired_vx
    return along > speed * speed and abs(across) < SETTLED * along / speed


@kernel
def effort_now(steps, speed):
    """Share of full effort after so many steps of turning."""
    steps = min(steps, 3)
    if speed < SLOW:
        return LAG_FROM_REST[steps]
    if speed < WALKING:
        return LAG_WALKING[steps]
    return LAG_SPRINTING[steps] if speed > SPRINTING else LAG_RUNNING[steps]


@kernel
def redirect(player, want, braking, effort, fresh, off):
    """Gather speed along the wanted direction while braking, by `braking` m/s, what is across or against it.

    `fresh` is what is gained in m/s in a direction in which he hardly moves yet, `off` his speed at once after a stop.
    """
    speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
    if want < 1e-6:
        keep = max(speed - braking, 0.0) / max(speed, 1e-9)
        return player.vx * keep, player.vy * keep
    ux, uy = player.desired_vx / want, player.desired_vy / want
    along = player.vx * ux + player.vy * uy
    across_x, across_y = player.vx - along * ux, player.vy - along * uy
    across = math.sqrt(across_x * across_x + across_y * across_y)
    if along < -1e-6:
        left = 1.0 - speed / braking  # share of the step after he has come to a stop
        keep = max(-left, 0.0) / (1.0 - left)
        start = min(max(left, 0.0) * off, want)
        return player.vx * keep + start * ux, player.vy * keep + start * uy
    keep = max(across - braking, 0.0) / across if across > 1e-9 else 0.0
    if along < want:
        more = fresh if along < JUMP - SURE and across > SETTLED else gain(along, player.top_speed, effort)
        along = min(along + more, want)
    else:
        along = max(along - braking, want)
    return along * ux + across_x * keep, along * uy + across_y * keep


@kernel
def gain(speed, top_speed, effort):
    """Speed in m/s gained in a step by a player who runs straight as hard as he can."""
    if speed <= 0.0:
        return JUMP * effort
    if speed < JUMP - SURE:
        return max(JUMP * effort - speed, JUMP_GAIN * effort * effort * STEP)
    time = STEP * effort * effort
    faster = speed
    if faster < CHANGES_FROM:
        lasts = min((CHANGES_FROM - faster) / ACCELERATION, time)
        faster += ACCELERATION * lasts
        time -= lasts
    if faster < CHANGES_TO and time > 0.0:
        lasts = min((CHANGES_TO - faster) / ACCELERATION_CHANGING, time)
        faster += ACCELERATION_CHANGING * lasts
        time -= lasts
    return faster - speed + min(ACCELERATION_SPRINT, max(top_speed - faster, 0.0) / ACCELERATION_TIME) * time
