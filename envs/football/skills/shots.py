"""Shots: where they are aimed, and what body, speed and skill make of the aim.

A shot is a mixture of what was meant and of what a bad one would be: dragged towards the run, scattered, higher and
weaker. How bad a bad one is follows from the run, its speed and the effort; how much of it there is, from a draw that
better shooters bend in their favour. The law and its numbers are those documented of Google Research Football, whose
animations enter as one number, the share of power that a kick from the stand reaches. Read next: `skills.passes`.
"""

from __future__ import annotations

import math

from envs.football.physics.pitch import attacked_goal_x
from envs.football.physics.vectors import length
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

# Aim
AIM_WIDEST, AIM_POWER = 3.33, 0.7  # m from the middle of the goal when the keys point a quarter turn off it
AIM_LEAD = 0.12  # s of the player's run, from where he aims
ASTERN, ASTERN_SHARE = 0.02, 0.23  # rad within which keys point straight away from the goal; aim then

# Power
FULL_POWER = 45.0  # m/s
LEAST_POWER, GAUGE_POWER = 0.7, 0.3  # share of it without the gauge, and what the gauge adds
STRONGEST, STRENGTH = 32.0, 13.0  # m/s that anybody reaches, and that a perfect shot power adds
STAND_SHARE, RUN_SHARE = 0.78, 0.95  # share of it standing, and running
RUNNING_FROM = 3.0  # m/s
STEP_IN = 1.0  # m/s, the stride that a standing player takes into the ball
SWING_MOST = 5.2  # m/s, the swing slows a sprinter to this
ACROSS_FROM, ACROSS_RANGE, ACROSS_WEAK = 0.785, 0.534, 0.04  # rad from run to shot, from and more; power lost
MEETING_GAIN = 0.2  # more power from a ball that comes with 10 m/s

# What makes a shot hard: each share of ease is lost in full at the worst
EASY_ANGLE = 0.162 * math.pi  # rad between run and shot up to which the direction is no matter
DIRECTION_WEIGHT, SPEED_WEIGHT, MEETING_WEIGHT, EFFORT_WEIGHT = 0.68, 0.3, 0.4, 0.4
EASY_SPEED, SPEED_RANGE = 3.5, 4.0  # m/s
VOLLEY_SKILL = 0.37
EFFORT_FROM, EFFORT_RANGE = 30.0, 70.0  # m/s

# The bad shot
DRAG, SCATTER = 0.9, 0.46
HEIGHT, HEIGHT_MEANT = 0.7, 0.05
WEAKNESS = 0.5

# Curl
BEND = 0.5  # share of the angle between body and shot, by which the shot starts off towards the body
TWIST = 0.28 * math.pi  # rad, the body has turned with the leg to be no further off
BEND_SLOW, BEND_FAST, FASTEST = 0.4, 0.6, 70.0
CURL, CURL_SPREAD, CURL_TAKEN = -420.0, 14.0, 0.7  # rad/s per unit of bend: it curls back; rad/s
SHOT_SPIN, SPIN_SPREAD, SPIN_BAD = -1.65, 0.3, 0.7  # m/s; shares of it that vary, always and with a bad shot

# Skills of the players of Google Research Football by index within the team: of shooting, and of shot power
SHOT_SKILL = (0.35, 0.44, 0.31, 0.24, 0.36, 0.69, 0.36, 0.53, 0.68, 0.68, 0.68)
SHOT_STRENGTH = (0.65, 0.57, 0.56, 0.64, 0.53, 0.69, 0.56, 0.62, 0.68, 0.68, 0.68)
SKILL_WEIGHT = 0.7


@kernel
def aim_shot(match, player, ux, uy):
    """Aim at the goal line: the further the keys (ux, uy) point off the middle of the goal, the further off it.

    Straight away from it they prefer no side: then he aims to that on which he turns round.
    """
    goal_x = attacked_goal_x(player.team)
    dx = goal_x - player.x - AIM_LEAD * player.vx
    dy = -player.y - AIM_LEAD * player.vy
    deviation = math.atan2(dx * uy - dy * ux, dx * ux + dy * uy)
    share = min(abs(deviation) / (0.5 * math.pi), 1.0) ** AIM_POWER
    side = 1.0 if deviation * dx > 0.0 else -1.0
    if math.pi - abs(deviation) < ASTERN:
        left = math.copysign(ASTERN_SHARE, goal_x)  # as he sees it: turned with the pitch
        side = left if uniform(match) < 0.5 else -left
    player.aim_x, player.aim_y = goal_x, side * AIM_WIDEST * share


@kernel
def eased(x, weight):
    """Mix x in [0, 1] with the sine curve through (0, 0), (0.5, 0.5) and (1, 1)."""
    return x + weight * (0.5 + 0.5 * math.sin((x - 0.5) * math.pi) - x)


@kernel
def angle_between(ax, ay, bx, by):
    """Angle in rad from direction a to direction b, positive to the left."""
    return math.atan2(ax * by - ay * bx, ax * bx + ay * by)


@kernel
def strike(match, player, ux, uy, power):
    """Give the ball the velocity and curl of a shot meant along (ux, uy), `power` in [0, 1] of the gauge."""
    ball = match.ball
    rx, ry, speed = run_at_contact(player)
    meeting = min(length(speed * rx - ball.vx, speed * ry - ball.vy) / 10.0, 1.0)
    off = abs(angle_between(rx, ry, ux, uy))
    along = eased(1.0 - max(off - EASY_ANGLE, 0.0) / math.pi, 0.8) ** 0.8
    force = force_of(player, along, speed, power) * (1.0 + MEETING_GAIN * meeting)
    force *= 1.0 - ACROSS_WEAK * min(max((off - ACROSS_FROM) / ACROSS_RANGE, 0.0), 1.0)
    hard = 1.0 - ease(along, speed, meeting, force)
    exponent = SKILL_WEIGHT * SHOT_SKILL[player.shirt % len(SHOT_SKILL)] * player.skill
    bad = uniform(match) ** exponent
    sx, sy, sz = bad_direction(match, rx, ry, ux, uy, hard)
    weak = force * (1.0 - WEAKNESS * hard**0.7) * bad
    meant = force * (1.0 - bad) / math.sqrt(1.0 + HEIGHT_MEANT * HEIGHT_MEANT)
    ball.vx, ball.vy = meant * ux + weak * sx, meant * uy + weak * sy
    ball.vz = meant * HEIGHT_MEANT + weak * sz
    bend(match, player)
    spin_back(match, SPIN_SPREAD + SPIN_BAD * bad)


@kernel
def run_at_contact(player):
    """Direction and speed in m/s of the body when the foot meets the ball; who stands steps in where he looks."""
    speed = length(player.vx, player.vy)
    if speed < STEP_IN:
        return player.facing_x, player.facing_y, STEP_IN
    return player.vx / speed, player.vy / speed, min(speed, SWING_MOST)


@kernel
def force_of(player, along, speed, power):
    """Speed in m/s that is meant: by the gauge, less across the run and from the stand, and what he has in him."""
    share = (0.7 + 0.3 * along) * (0.7 + 0.3 * min(speed / 8.0, 1.0) ** 0.3)
    force = share * FULL_POWER * (LEAST_POWER + GAUGE_POWER * math.sqrt(power))
    stand = STAND_SHARE + (RUN_SHARE - STAND_SHARE) * min((speed - STEP_IN) / (RUNNING_FROM - STEP_IN), 1.0)
    strength = STRENGTH * SHOT_STRENGTH[player.shirt % len(SHOT_STRENGTH)] * player.skill
    return min(force, (STRONGEST + strength) * (0.2 + 0.8 * stand))


@kernel
def ease(along, speed, meeting, force):
    """How easy the shot is, 0 to 1: along the run, at a jog, with a still ball, without effort."""
    jog = 1.0 - min(abs(speed - EASY_SPEED) / SPEED_RANGE, 1.0)
    still = 1.0 - meeting * VOLLEY_SKILL
    calm = eased(1.0 - min(max((force - EFFORT_FROM) / EFFORT_RANGE, 0.0), 1.0), 1.0)
    result = 1.0 - DIRECTION_WEIGHT * (1.0 - along)
    result *= 1.0 - SPEED_WEIGHT * (1.0 - jog)
    result *= 1.0 - MEETING_WEIGHT * (1.0 - still)
    return result * (1.0 - EFFORT_WEIGHT * (1.0 - calm))


@kernel
def bad_direction(match, rx, ry, ux, uy, hard):
    """Unit vector of a bad shot: between shot and run, scattered, and too high."""
    drag = DRAG * hard
    x, y = drag * rx + (1.0 - drag) * ux, drag * ry + (1.0 - drag) * uy
    size = length(x, y) + 1e-9
    spread = SCATTER * hard
    along, across = spread * (2.0 * uniform(match) - 1.0), spread * (2.0 * uniform(match) - 1.0)
    x, y = x / size + along * ux - across * uy, y / size + along * uy + across * ux
    z = spread * (2.0 * uniform(match) - 1.0)
    size = math.sqrt(x * x + y * y + z * z) + 1e-9
    x, y = x / size, y / size
    z = z / size + HEIGHT * eased(hard**0.7, 0.7)
    size = math.sqrt(x * x + y * y + z * z) + 1e-9
    return x / size, y / size, z / size


@kernel
def bend(match, player):
    """Let a shot start off towards the body and curl back."""
    ball = match.ball
    flat = length(ball.vx, ball.vy) + 1e-9
    turn = angle_between(ball.vx, ball.vy, player.facing_x, player.facing_y)
    amount = BEND * math.copysign(min(abs(turn), TWIST), turn) / math.pi
    speed = math.sqrt(flat * flat + ball.vz * ball.vz)
    angle = amount * (BEND_SLOW + BEND_FAST * min(speed / FASTEST, 1.0))
    cosine, sine = math.cos(angle), math.sin(angle)
    ball.vx, ball.vy = ball.vx * cosine - ball.vy * sine, ball.vx * sine + ball.vy * cosine
    ball.curl = CURL_TAKEN * (CURL * amount + CURL_SPREAD * (2.0 * uniform(match) - 1.0))


@kernel
def spin_back(match, spread):
    """Give a shot back spin that varies by this share in its direction and across."""
    ball = match.ball
    flat = length(ball.vx, ball.vy) + 1e-9
    back = SHOT_SPIN * (1.0 + spread * (2.0 * uniform(match) - 1.0))
    across = SHOT_SPIN * spread * (2.0 * uniform(match) - 1.0)
    ball.spin_x = (back * ball.vx - across * ball.vy) / flat
    ball.spin_y = (back * ball.vy + across * ball.vx) / flat
