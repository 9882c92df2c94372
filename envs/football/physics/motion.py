"""The motion of a body in a step (a run, a slide, a dive, lying on the ground) and its facing.

Read next: `physics.running`, then `physics.dribble`; `frames` moves the bodies.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import NOBODY, STEP
from regista.envs.football.physics.dribble import run_with_ball
from regista.envs.football.physics.pitch import attacked_goal_x
from regista.envs.football.physics.running import BRAKING, STANCE, TOES, run_free
from regista.envs.football.physics.vectors import apart, toward
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Slide(NamedTuple):
    """A slide: a glide (after a jump, if from standing), a steady slowdown to a stop, a pause, and getting up."""

    time: float = 1.4  # s in total
    glide: float = 1.15  # s left when the slowdown begins
    stops: float = 0.74  # s left at the stop
    rises: float = 0.45  # s left when getting up begins
    jump: float = 1.9  # m/s, maximum speed of a slide from standing
    start: float = 0.4  # m/s in a step, plus
    gain: float = 1.6  # this factor of the speed before
    rise_speed: float = 0.45  # m/s at most while getting up
    rise_gain: float = 2.0  # m/s² while getting up


class FollowThrough(NamedTuple):
    """How a body runs on after a kick, independent of the desired velocity."""

    time: float = 0.35  # s
    slows: float = 6.0  # m/s²


class Tiring(NamedTuple):
    """How running tires a player."""

    per_metre: float = 7.3e-4  # per meter of running
    fast: float = 1.25e-5  # less by this per m/s: fast meters tire less
    most: float = 0.99


# Fitted to traces of Google Research Football: `lab.benchmarks --suite grf`, family motion.
SLIDE, FOLLOW, TIRING = Slide(), FollowThrough(), Tiring()
FALL_FRICTION = 9.0  # m/s² for a keeper after a dive
SUDDEN = 0.1  # s; a shot that was just taken and reaches the keeper sooner leaves no time to react
AT_REST = 0.3  # m/s
AT_FEET = 0.8  # m from the body to the carrier's ball
BEFORE_HIM = 1.095  # m to a free ball; a nearer player waits for it, and takes a stance for it at the first whistle
SETS_HIMSELF = 0.02  # s added to the stance for it
IN_REACH = 0.75  # m; at the first whistle a nearer ball is played at once
NEAR_BALL = 10.0  # m to the ball, within which a standing player is on the toes
FIRST_NEAR = 12.0  # m; the same for the first player of a team at the ball, once play has begun
TURN = 0.4  # rad per step, when turning on the spot
TURN_COS, TURN_SIN = math.cos(TURN), math.sin(TURN)


@kernel
def take_stance(match):
    """At the first whistle, put every body into a random phase of its idle movement, or on its toes near the ball.

    A player with the ball just ahead takes a stance for it first; a player with the ball in reach plays it at once.
    """
    for i in range(match.num_players):
        player = match.players[i]
        away = apart(player, match.ball)
        drawn = uniform(match)
        player.stance_wait = TOES * (1.0 + drawn) if BEFORE_HIM < away < NEAR_BALL else STANCE * drawn
        if away < IN_REACH:
            player.stance_wait = 0.0
        elif away < BEFORE_HIM:
            player.stance_wait += SETS_HIMSELF
            player.touch_wait = player.stance_wait


@kernel
def plan_motion(match, i):
    """Set player i's velocity and facing for this step."""
    player = match.players[i]
    speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
    if player.down_wait > 0.0:
        vx, vy = slowed(player, speed)
    elif match.saver == i:
        vx, vy = (player.vx, player.vy) if struck(match) else thrown(player)
    elif match.carrier == i and match.keeper_holding != i:
        vx, vy = run_with_ball(match, i, speed)
    elif match.last_touch == i and match.was_kicked and match.kick_age < FOLLOW.time:
        player.turning = 0
        keep = max(speed - FOLLOW.slows * STEP, 0.0) / max(speed, 1e-9)
        vx, vy = keep * player.vx, keep * player.vy
    else:
        ready = int(player.turning == 0 and player.stance_wait == 0.0 and on_his_toes(match, i))
        player.turning += ready
        vx, vy = run_free(player, speed)
        player.turning -= min(ready, player.turning)
    player.stance_wait = max(player.stance_wait - STEP, 0.0)
    player.vx, player.vy = vx, vy
    player.tiredness = min(
        player.tiredness + max(TIRING.per_metre - TIRING.fast * speed, 0.0) * speed * STEP, TIRING.most
    )
    new_speed = math.sqrt(vx * vx + vy * vy)
    if new_speed > AT_REST and player.kick_wait <= 0.0:
        player.facing_x, player.facing_y = vx / new_speed, vy / new_speed
    elif match.carrier == i and player.kick == 0:
        turn_to_goal(player)


@kernel
def on_his_toes(match, i):
    """Return whether a standing player starts without lag: the ball is near, but no free ball just ahead."""
    player = match.players[i]
    away, near = apart(match.ball, player), FIRST_NEAR if match.chaser[player.team] == i else NEAR_BALL
    return away < near and not (match.carrier == NOBODY and AT_FEET <= away < BEFORE_HIM)


@kernel
def turn_to_goal(player):
    """Turn the body of a standing carrier towards the attacked goal, by at most `TURN`."""
    goal_x = attacked_goal_x(player.team)
    ux, uy = toward(goal_x - player.x, -player.y)
    if player.facing_x * ux + player.facing_y * uy >= TURN_COS:
        player.facing_x, player.facing_y = ux, uy
        return
    sine = TURN_SIN if player.facing_x * uy - player.facing_y * ux >= 0.0 else -TURN_SIN
    x, y = player.facing_x, player.facing_y
    player.facing_x, player.facing_y = x * TURN_COS - y * sine, x * sine + y * TURN_COS


@kernel
def slowed(player, speed):
    """Return the velocity after a step on the ground, in a slide or after a dive; a start may follow immediately."""
    player.turning = 1
    if player.is_sliding:
        new = slid(player.down_wait, speed)
        return new * player.facing_x, new * player.facing_y
    if speed < 1e-6:
        return 0.0, 0.0
    keep = max(speed - FALL_FRICTION * STEP, 0.0) / speed
    return player.vx * keep, player.vy * keep


@kernel
def slid(left, speed):
    """Return the speed after a step of a slide that lasts `left` more seconds."""
    if left > SLIDE.glide:
        return max(speed, min(SLIDE.start + SLIDE.gain * speed, SLIDE.jump))
    if left > SLIDE.stops:
        return speed * max(1.0 - STEP / (left - SLIDE.stops), 0.0)
    return min(speed + SLIDE.rise_gain * STEP, SLIDE.rise_speed) if left < SLIDE.rises else 0.0


@kernel
def struck(match):
    """Return whether a shot that has just been taken reaches the keeper before any reaction."""
    return match.was_kicked and match.kick_age < 1.5 * STEP and match.save_wait < SUDDEN


@kernel
def thrown(player):
    """Return the velocity after a step of a diving keeper towards the target: no lag, double effort."""
    dx, dy = player.desired_vx - player.vx, player.desired_vy - player.vy
    size = math.sqrt(dx * dx + dy * dy)
    keep = min(1.0, 2.0 * BRAKING.power * STEP / size) if size > 0.0 else 1.0
    return player.vx + keep * dx, player.vy + keep * dy
