"""How a body responds to a command: from its velocity to the desired one, step by step.

A body first finishes its stride, then brakes hard all velocity in other directions, starts with a jump, and
accelerates. The numbers are fitted to traces of Google Research Football. Read next: `physics.dribble`, how this
changes with the ball.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import GK, RUN_SPEED, STEP
from regista.kernels.jit import kernel


class Braking(NamedTuple):
    """Braking: the ranges of speed, and the strength."""

    power: float = 30.0  # m/s²
    slow: float = 2.7  # m/s, below which the lag is that of a start
    walking: float = 3.8  # m/s, below which the lag is that of a walk
    sprinting: float = 6.0  # m/s, above which the lag is that of a sprint


class Start(NamedTuple):
    """Acceleration: a jump, a steady part, a change of gait, an approach to top speed."""

    jump: float = 2.0  # m/s, immediate speed from standing
    jump_gain: float = 13.0  # m/s² until the jump is complete, and into a new direction
    after_turn: float = 1.1  # m/s, immediate speed after a stop to turn
    acceleration: float = 8.5  # m/s² from the jump to the change of gait
    changes_from: float = 4.9  # m/s; near RUN_SPEED the change of gait slows the acceleration
    changes_to: float = 5.1  # m/s
    acceleration_changing: float = 2.1  # m/s², meanwhile
    acceleration_sprint: float = 4.9  # m/s² at most, above that
    time_sprint: float = 0.39  # s of the approach to top speed


class Bend(NamedTuple):
    """Bends: small changes of direction on the run, such as those of a player whose target moves with the game."""

    most: float = 0.39  # tangent of the maximum angle to the desired direction; just below 0.4, a frequent ratio
    share: float = 0.5  # share of the remaining angle turned in a step, from the second step on
    effort: float = 0.85  # share of full effort in a sprinter's acceleration meanwhile


# Fitted to traces of Google Research Football: `lab.benchmarks --suite grf`, family motion; the bend to runs of
# backs and chasers in drawn scenes.
BRAKING, START, BEND = Braking(), Start(), Bend()
# Lag of the body: share of full effort in the steps after command and velocity begin to differ.
LAG_FROM_REST = (0.0, 0.66, 1.0, 1.0)  # a standing player starts a step later: STANCE / 2, in steps
LAG_SLOW = (0.6, 1.0, 1.0, 1.0)
LAG_WALKING = (0.1, 0.58, 1.0, 1.0)
LAG_RUNNING = (0.0, 0.0, 0.25, 1.0)
LAG_SPRINTING = (0.0, 0.15, 0.75, 1.0)
STANCE = 0.25  # s of the idle movement, which ends before a start; its phase is random at the first whistle
TOES = 0.03  # s, the same for a player on the toes near the ball; twice as long at most
READY = 4  # "turning" of a body without further lag
# Speeds often equal a threshold between two rules, such as 0.1 off the command or 0.5 after braking. Rounding, which
# depends on the direction, must not decide which rule applies.
SURE = 1e-6  # m/s
SETTLED = 0.1 + SURE  # m/s: command and velocity this close count as equal
UNDER_WAY = 0.5 - SURE  # m/s


@kernel
def run_free(player, speed):
    """Return the velocity after a step of running without the ball towards the desired velocity."""
    dx, dy = player.desired_vx - player.vx, player.desired_vy - player.vy
    if dx * dx + dy * dy < SETTLED * SETTLED:
        player.turning = 0
        return player.desired_vx, player.desired_vy
    want = math.sqrt(player.desired_vx * player.desired_vx + player.desired_vy * player.desired_vy)
    if straight(player, speed):
        player.turning = 0
        effort = 1.0
    elif bends(player, speed):
        return bend(player, speed, want)
    else:
        effort = lagging(effort_now(player, speed), player.start_lag)
        player.turning += 1
    if effort == 0.0:
        return player.vx, player.vy
    fresh = START.jump_gain * max(RUN_SPEED / max(want, 1.0), 1.0) * effort * STEP
    return redirect(player, want, BRAKING.power * effort * STEP, effort, fresh, START.after_turn)


@kernel
def straight(player, speed):
    """Return whether a player already runs in the desired direction, but slower; then no lag applies."""
    if speed < UNDER_WAY:
        return False
    along = player.vx * player.desired_vx + player.vy * player.desired_vy
    across = player.vx * player.desired_vy - player.vy * player.desired_vx
    return along > speed * speed and abs(across) < SETTLED * along / speed


@kernel
def bends(player, speed):
    """Return whether the desired velocity of a running player is at least as fast, in almost the same direction.

    Keepers do not bend their runs: their parameters were fitted to a body that turns immediately or not at all.
    """
    if speed < UNDER_WAY or player.role == GK:
        return False
    along = player.vx * player.desired_vx + player.vy * player.desired_vy
    across = player.vx * player.desired_vy - player.vy * player.desired_vx
    return along > speed * speed and abs(across) < BEND.most * along


@kernel
def bend(player, speed, want):
    """Return the velocity after a step in which a player accelerates and turns a little, without the lag of the stride.

    After a later large change of direction the stride may or may not be near its end, so the lag alternates between one
    step and two steps.
    """
    share = BEND.share if player.turning > 0 else 0.0
    player.turning = 2 if player.turning == 1 else 1
    more = gain(speed, player.top_speed, BEND.effort if speed > RUN_SPEED + SURE else 1.0)
    pace = speed / want
    vx = player.vx + share * (pace * player.desired_vx - player.vx)
    vy = player.vy + share * (pace * player.desired_vy - player.vy)
    keep = min(speed + more, want) / math.sqrt(vx * vx + vy * vy)
    return keep * vx, keep * vy


@kernel
def effort_now(player, speed):
    """Return the share of full effort with which a body responds in this step."""
    steps = min(player.turning, 3)
    if player.stance_wait > 0.0:
        return max(1.0 - player.stance_wait / STEP, 0.0)
    if speed < UNDER_WAY:
        return LAG_FROM_REST[steps]
    if speed < BRAKING.slow:
        return LAG_SLOW[steps]
    if speed < BRAKING.walking:
        return LAG_WALKING[steps]
    return LAG_SPRINTING[steps] if speed > BRAKING.sprinting else LAG_RUNNING[steps]


@kernel
def lagging(effort, lag):
    """Return the share of full effort if the body's lag is `lag` times as long."""
    return max(effort + (1.0 - effort) * (1.0 - lag), 0.0)


@kernel
def redirect(player, want, braking, effort, fresh, off):
    """Accelerate along the desired direction while braking, by `braking` m/s, velocity across or against it.

    `fresh` is the gain in m/s in a direction with hardly any velocity yet, `off` the immediate speed after a stop.
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
        left = 1.0 - speed / braking  # share of the step after the stop
        keep = max(-left, 0.0) / (1.0 - left)
        start = min(max(left, 0.0) * off, want)
        return player.vx * keep + start * ux, player.vy * keep + start * uy
    keep = max(across - braking, 0.0) / across if across > 1e-9 else 0.0
    if along < want:
        more = fresh if along < START.jump - SURE and across > SETTLED else gain(along, player.top_speed, effort)
        along = min(along + more, want)
    else:
        along = max(along - braking, want)
    return along * ux + across_x * keep, along * uy + across_y * keep


@kernel
def gain(speed, top_speed, effort):
    """Return the speed in m/s gained in a step by a player who runs straight at full effort."""
    if speed <= 0.0:
        return START.jump * effort
    if speed < START.jump - SURE:
        return max(START.jump * effort - speed, START.jump_gain * effort * effort * STEP)
    time = STEP * effort * effort
    faster = speed
    if faster < START.changes_from:
        lasts = min((START.changes_from - faster) / START.acceleration, time)
        faster += START.acceleration * lasts
        time -= lasts
    if faster < START.changes_to and time > 0.0:
        lasts = min((START.changes_to - faster) / START.acceleration_changing, time)
        faster += START.acceleration_changing * lasts
        time -= lasts
    return faster - speed + min(START.acceleration_sprint, max(top_speed - faster, 0.0) / START.time_sprint) * time
