"""Shots: where they are aimed, and the effects of body, speed and skill on the aim.

A shot is a mixture of the intended shot and of a bad shot, which is dragged towards the run, scattered, higher and
weaker. The run, its speed and the effort determine the bad shot. Its share is random, and skill reduces it. The law and
its numbers are documented by Google Research Football. Its animations are modeled by one number, the share of power
that a standing kick reaches. Read next: `skills.passes`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import NOBODY
from regista.envs.football.physics.bodies import PUSH
from regista.envs.football.physics.pitch import attacked_goal_x
from regista.envs.football.physics.vectors import length
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Aim(NamedTuple):
    """Where on the goal line a shot is aimed."""

    widest: float = 3.33  # m from the middle of the goal, if the held direction is a quarter turn off it
    power: float = 0.7
    lead: float = 0.12  # s by which the player's run is extrapolated to the point of aim
    astern: float = 0.02  # rad within which the held direction counts as straight away from the goal
    astern_share: float = 0.23  # share of the widest aim in this case


class Power(NamedTuple):
    """The intended speed of a shot."""

    full: float = 45.0  # m/s
    least: float = 0.7  # share of the full speed with an empty gauge
    gauge: float = 0.3  # share that a full gauge adds
    strongest: float = 32.0  # m/s, the maximum of any player
    strength: float = 13.0  # m/s that perfect shot power adds
    stand_share: float = 0.78  # share of the speed for a standing player
    run_share: float = 0.95  # share of the speed for a runner
    running_from: float = 3.0  # m/s
    step_in: float = 1.0  # m/s, the stride of a standing player into the ball
    swing_most: float = 5.2  # m/s to which the swing slows a sprinter
    across_from: float = 0.785  # rad between run and shot, from which on power is lost
    across_range: float = 0.534  # rad more, at which this share of the power is lost:
    across_weak: float = 0.04
    pushed: float = 0.6  # share of the power that the hardest push costs
    meeting_gain: float = 0.2  # share of power gained from a ball that approaches at 10 m/s


class Difficulty(NamedTuple):
    """The difficulty of a shot: each share of ease is lost in full in the worst case."""

    easy_angle: float = 0.162 * math.pi  # rad between run and shot up to which the direction has no effect
    direction: float = 0.68
    speed: float = 0.3
    meeting: float = 0.4
    effort: float = 0.4
    pushed: float = 0.7
    easy_speed: float = 3.5  # m/s
    speed_range: float = 4.0  # m/s
    volley_skill: float = 0.37
    effort_from: float = 30.0  # m/s
    effort_range: float = 70.0  # m/s
    skill_weight: float = 0.7


class BadShot(NamedTuple):
    """The result of the hardest shot."""

    drag: float = 0.8  # share by which it is dragged towards the run
    scatter: float = 0.5
    height: float = 0.7
    height_meant: float = 0.05  # height of a good shot
    weakness: float = 0.5


class Curl(NamedTuple):
    """How a shot bends."""

    bend: float = 0.5  # share of the angle between body and shot by which the shot starts off towards the body
    twist: float = 0.18 * math.pi  # rad by which the body has turned with the leg to reduce the angle
    twist_volley: float = 0.36 * math.pi  # rad, the same for a first-time shot
    slow: float = 0.4  # share of this for a slow shot
    fast: float = 0.6  # share added for the fastest shot, at
    fastest: float = 70.0  # m/s
    per_bend: float = -420.0  # rad/s per unit of bend; the ball curls back
    spread: float = 14.0  # rad/s
    taken: float = 0.7
    spin: float = -1.65  # m/s of back spin
    spin_kept: float = 0.3  # share of its spin that the ball keeps: top spin, for a carrier
    spin_spread: float = 0.3  # share of the spin that always varies
    spin_bad: float = 0.7  # share that varies with a bad shot


# The law and its numbers are documented by Google Research Football; power and scatter are checked by
# `lab.benchmarks --suite grf`, family shots.
AIM, POWER, HARD, BAD, CURL = Aim(), Power(), Difficulty(), BadShot(), Curl()
# Skills of Google Research Football's players by index within the team: of shooting, and of shot power
SHOT_SKILL = (0.35, 0.44, 0.31, 0.24, 0.36, 0.69, 0.36, 0.53, 0.68, 0.68, 0.68)
SHOT_STRENGTH = (0.65, 0.57, 0.56, 0.64, 0.53, 0.69, 0.56, 0.62, 0.68, 0.68, 0.68)


@kernel
def aim_shot(match, player, ux, uy):
    """Aim at the goal line: the more the held direction (ux, uy) is off the middle of the goal, the wider the aim.

    A direction straight away from the goal prefers no side; the aim is then on the side of the turn.
    """
    goal_x = attacked_goal_x(player.team)
    dx = goal_x - player.x - AIM.lead * player.vx
    dy = -player.y - AIM.lead * player.vy
    deviation = math.atan2(dx * uy - dy * ux, dx * ux + dy * uy)
    share = min(abs(deviation) / (0.5 * math.pi), 1.0) ** AIM.power
    side = 1.0 if deviation * dx > 0.0 else -1.0
    if math.pi - abs(deviation) < AIM.astern:
        left = math.copysign(AIM.astern_share, goal_x)  # as the player sees it: rotated with the pitch
        side = left if uniform(match) < 0.5 else -left
    player.aim_x, player.aim_y = player.x + dx, player.y + dy + side * AIM.widest * share


@kernel
def eased(x, weight):
    """Mix x in [0, 1] with the sine curve through (0, 0), (0.5, 0.5) and (1, 1)."""
    return x + weight * (0.5 + 0.5 * math.sin((x - 0.5) * math.pi) - x)


@kernel
def angle_between(ax, ay, bx, by):
    """Return the angle in rad from direction a to direction b, positive to the left."""
    return math.atan2(ax * by - ay * bx, ax * bx + ay * by)


@kernel
def strike(match, player, ux, uy, power):
    """Give the ball the velocity and curl of a shot intended along (ux, uy); `power` in [0, 1] is the gauge."""
    ball = match.ball
    rx, ry, speed = run_at_contact(player)
    meeting = min(length(speed * rx - ball.vx, speed * ry - ball.vy) / 10.0, 1.0)
    off = abs(angle_between(rx, ry, ux, uy))
    along = eased(1.0 - max(off - HARD.easy_angle, 0.0) / math.pi, 0.8) ** 0.8
    force = force_of(player, along, speed, power) * (1.0 + POWER.meeting_gain * meeting)
    force *= 1.0 - POWER.across_weak * min(max((off - POWER.across_from) / POWER.across_range, 0.0), 1.0)
    pushed = player.pushed / PUSH.most
    hard = 1.0 - ease(along, speed, meeting, force) * (1.0 - HARD.pushed * pushed)
    exponent = HARD.skill_weight * SHOT_SKILL[player.shirt % len(SHOT_SKILL)] * player.skill
    bad = uniform(match) ** exponent
    sx, sy, sz = bad_direction(match, rx, ry, ux, uy, hard)
    weak = force * (1.0 - BAD.weakness * hard**0.7) * bad
    meant = force * (1.0 - bad) / math.sqrt(1.0 + BAD.height_meant * BAD.height_meant)
    ball.vx, ball.vy = meant * ux + weak * sx, meant * uy + weak * sy
    ball.vz = meant * BAD.height_meant + weak * sz
    amount = bend(ball, player, CURL.twist_volley if match.carrier == NOBODY else CURL.twist, 1.0)
    ball.curl = CURL.taken * (CURL.per_bend * amount + CURL.spread * (2.0 * uniform(match) - 1.0))
    spin_back(match, CURL.spin_spread + CURL.spin_bad * bad)


@kernel
def run_at_contact(player):
    """Return the body's direction and speed in m/s when the foot meets the ball; a standing player steps forward."""
    speed = length(player.vx, player.vy)
    if speed < POWER.step_in:
        return player.facing_x, player.facing_y, POWER.step_in
    return player.vx / speed, player.vy / speed, min(speed, POWER.swing_most)


@kernel
def force_of(player, along, speed, power):
    """Return the intended speed in m/s from the gauge and the player's power, lower across the run or from standing."""
    share = (0.7 + 0.3 * along) * (0.7 + 0.3 * min(speed / 8.0, 1.0) ** 0.3)
    share *= 1.0 - POWER.pushed * player.pushed / PUSH.most
    force = share * POWER.full * (POWER.least + POWER.gauge * math.sqrt(power))
    stand = POWER.stand_share + (POWER.run_share - POWER.stand_share) * min(
        (speed - POWER.step_in) / (POWER.running_from - POWER.step_in), 1.0
    )
    strength = POWER.strength * SHOT_STRENGTH[player.shirt % len(SHOT_STRENGTH)] * player.skill
    return min(force, (POWER.strongest + strength) * (0.2 + 0.8 * stand))


@kernel
def ease(along, speed, meeting, force):
    """Return how easy the shot is, 0 to 1; easiest along the run, at a jog, with a still ball, without effort."""
    jog = 1.0 - min(abs(speed - HARD.easy_speed) / HARD.speed_range, 1.0)
    still = 1.0 - meeting * HARD.volley_skill
    calm = eased(1.0 - min(max((force - HARD.effort_from) / HARD.effort_range, 0.0), 1.0), 1.0)
    result = 1.0 - HARD.direction * (1.0 - along)
    result *= 1.0 - HARD.speed * (1.0 - jog)
    result *= 1.0 - HARD.meeting * (1.0 - still)
    return result * (1.0 - HARD.effort * (1.0 - calm))


@kernel
def bad_direction(match, rx, ry, ux, uy, hard):
    """Return the unit vector of a bad shot: between shot and run, scattered, and too high."""
    drag = BAD.drag * hard
    x, y = drag * rx + (1.0 - drag) * ux, drag * ry + (1.0 - drag) * uy
    size = length(x, y) + 1e-9
    spread = BAD.scatter * hard * match.engine.kick_spread
    along, across = spread * (2.0 * uniform(match) - 1.0), spread * (2.0 * uniform(match) - 1.0)
    x, y = x / size + along * ux - across * uy, y / size + along * uy + across * ux
    z = spread * (2.0 * uniform(match) - 1.0)
    size = math.sqrt(x * x + y * y + z * z) + 1e-9
    x, y = x / size, y / size
    z = z / size + BAD.height * eased(hard**0.7, 0.7)
    size = math.sqrt(x * x + y * y + z * z) + 1e-9
    return x / size, y / size, z / size


@kernel
def bend(ball, player, twist, share):
    """Let a kick start off towards the body, turned by `twist` rad with the leg; return the fastest kick's angle in
    rad.
    """
    flat = length(ball.vx, ball.vy) + 1e-9
    turn = angle_between(ball.vx, ball.vy, player.facing_x, player.facing_y)
    turn = math.copysign(min(abs(turn), twist), turn)
    if abs(turn) > 0.5 * math.pi:
        turn = math.copysign(math.pi - abs(turn), turn)  # for a kick behind the body
    amount = share * CURL.bend * turn / math.pi
    speed = math.sqrt(flat * flat + ball.vz * ball.vz)
    angle = amount * (CURL.slow + CURL.fast * min(speed / CURL.fastest, 1.0))
    cosine, sine = math.cos(angle), math.sin(angle)
    ball.vx, ball.vy = ball.vx * cosine - ball.vy * sine, ball.vx * sine + ball.vy * cosine
    return amount


@kernel
def spin_back(match, spread):
    """Give a shot back spin that varies by this share along and across, and keeps a part of the ball's spin."""
    ball = match.ball
    flat = length(ball.vx, ball.vy) + 1e-9
    back = CURL.spin * (1.0 + spread * (2.0 * uniform(match) - 1.0))
    across = CURL.spin * spread * (2.0 * uniform(match) - 1.0)
    ball.spin_x = CURL.spin_kept * ball.spin_x + (back * ball.vx - across * ball.vy) / flat
    ball.spin_y = CURL.spin_kept * ball.spin_y + (back * ball.vy + across * ball.vx) / flat
