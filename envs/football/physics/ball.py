"""The ball between two touches: air, ground, spin and the goal frame.

Forces are those of Google Research Football.
Read next: `frames`, which calls `advance_ball` a hundred times a second.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import (
    BALL_RADIUS,
    DT,
    GOAL_HALF_WIDTH,
    GOAL_HEIGHT,
    HALF_LENGTH,
    POST_RADIUS,
)
from regista.kernels.jit import kernel


class Air(NamedTuple):
    """Forces on a ball in flight."""

    gravity: float = 9.81  # m/s²
    drag: float = 0.015  # 1/m: deceleration is this times v²
    swerve: float = 0.3  # m/s² per rad/s of spin, at most
    swerve_turn: float = 0.94 * math.pi  # rad, range of the sine by which swerve grows and falls with speed,
    fastest: float = 70.0  # m/s, the speed at the end of that range
    swerve_power: float = 2.6
    spin_least: float = 0.5  # rad/s; a slower spin does not bend the flight


class Ground(NamedTuple):
    """Effects of the ground."""

    drag: float = 0.04  # 1/m
    friction: float = 1.6  # m/s²
    grass: float = 0.025  # m, height above the ground over which its grip fades out
    fading: float = 0.7  # exponent of this fading
    bounce: float = 0.62  # share of vertical speed kept,
    bounce_loss: float = 0.06  # m/s of vertical speed lost in addition
    rolling: float = 0.12  # m/s; a slower impact does not bounce
    grip: float = 0.01  # share of the difference between speed and spin that the ground removes in a frame,
    grip_bounce: float = 0.5  # the same at a bounce, in full from this impact on:
    soft_impact: float = 0.5  # m/s
    hard_impact: float = 12.0  # m/s more
    spin_gain: float = 0.345  # m/s by which spin may approach speed in a frame
    spin_gain_bounce: float = 1.38  # m/s, the same at a bounce


class Frame(NamedTuple):
    """Posts and crossbar."""

    reach: float = BALL_RADIUS + POST_RADIUS  # m, distance of the centers of post and ball at contact
    bounce: float = 0.8  # share of speed kept


# Google Research Football's own forces, checked by `lab.benchmarks --suite grf`, family ball.
AIR, GROUND, FRAME = Air(), Ground(), Frame()
MEAN_DRAG = 0.045  # 1/m, of a rolling ball: an estimate for predictions


@kernel
def advance_ball(ball):
    """Simulate the ball for one frame of 10 ms."""
    on_ground = ball.vz == 0.0 and ball.z <= BALL_RADIUS
    if on_ground and ball.vx == 0.0 and ball.vy == 0.0:
        return
    if on_ground:
        drag_on_ground(ball, 1.0, AIR.drag)
        if abs(ball.curl) > AIR.spin_least:
            swerve(ball, math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy))
            ball.vz = 0.0  # top spin bends the path down into the ground
    else:
        fly(ball)
    x, y, z = ball.x, ball.y, ball.z
    ball.x += ball.vx * DT
    ball.y += ball.vy * DT
    if abs(ball.x) > HALF_LENGTH - 1.0 and abs(ball.y) < GOAL_HALF_WIDTH + 1.0:
        hit_goal_frame(ball, x, y, z)


@kernel
def fly(ball):
    """Apply air and gravity to the ball for a frame, and the ground if it is near enough."""
    speed = math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy + ball.vz * ball.vz)
    keep = 1.0 - AIR.drag * speed * DT
    ball.vx *= keep
    ball.vy *= keep
    ball.vz = ball.vz * keep - AIR.gravity * DT
    swerve(ball, speed)
    ball.z += ball.vz * DT
    if ball.z < BALL_RADIUS:
        bounce(ball)
    if ball.z < BALL_RADIUS + GROUND.grass:
        lifted = (ball.z - BALL_RADIUS) / GROUND.grass
        drag_on_ground(ball, (1.0 - lifted) ** GROUND.fading if lifted != 0.0 else 1.0, 0.0)  # since a power is slow


@kernel
def swerve(ball, speed):
    """Bend the flight of a spinning ball (Magnus effect), most at about 37 m/s: top spin down, curl to the side."""
    wx, wy, wz = -ball.spin_y / BALL_RADIUS, ball.spin_x / BALL_RADIUS, ball.curl
    if wx * wx + wy * wy + wz * wz < AIR.spin_least * AIR.spin_least or speed < 1.0:
        return
    force = AIR.swerve * math.sin(min(speed / AIR.fastest, 1.0) * AIR.swerve_turn) ** AIR.swerve_power * DT / speed
    vx, vy, vz = ball.vx, ball.vy, ball.vz
    ball.vx += force * (wy * vz - wz * vy)
    ball.vy += force * (wz * vx - wx * vz)
    ball.vz += force * (wx * vy - wy * vx)


@kernel
def drag_on_ground(ball, contact, air):
    """Slow the ball by the ground's friction (and by air drag `air`); speed and spin approach each other.

    `contact` in [0, 1] is the share of the ground's grip that acts.
    """
    speed = math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy)
    loss = (((GROUND.drag * contact + air) * speed * speed) + GROUND.friction * contact) * DT
    if loss >= speed:
        ball.vx, ball.vy, ball.spin_x, ball.spin_y = 0.0, 0.0, 0.0, 0.0
        return
    keep = 1.0 - loss / speed
    ball.vx *= keep
    ball.vy *= keep
    even_out(ball, GROUND.grip * contact, GROUND.spin_gain * contact)


@kernel
def even_out(ball, share, gain):
    """Move speed towards spin by a share of their difference, and spin towards speed by at most `gain` m/s."""
    slip_x, slip_y = ball.spin_x - ball.vx, ball.spin_y - ball.vy
    ball.vx += share * slip_x
    ball.vy += share * slip_y
    squared = slip_x * slip_x + slip_y * slip_y
    if squared <= gain * gain:  # rolling; compared without a square root
        ball.spin_x, ball.spin_y, ball.curl = ball.vx, ball.vy, 0.0
        return
    spin_share = min(gain / math.sqrt(squared), 1.0 - share)
    ball.spin_x -= spin_share * slip_x
    ball.spin_y -= spin_share * slip_y
    ball.curl -= spin_share * ball.curl


@kernel
def bounce(ball):
    """Reflect the ball off the ground."""
    impact = abs(ball.vz)
    ball.z = BALL_RADIUS
    ball.vz = max(GROUND.bounce * impact - GROUND.bounce_loss, 0.0)
    if ball.vz < GROUND.rolling:
        ball.vz = 0.0
    even_out(
        ball,
        GROUND.grip_bounce * min(max((impact - GROUND.soft_impact) / GROUND.hard_impact, 0.0), 1.0),
        GROUND.spin_gain_bounce,
    )


@kernel
def hit_goal_frame(ball, x, y, z):
    """Bounce the ball off a post or the crossbar that it met on its way from (x, y, z) to its position."""
    goal_x = HALF_LENGTH if ball.x > 0.0 else -HALF_LENGTH
    post_y = GOAL_HALF_WIDTH if ball.y > 0.0 else -GOAL_HALF_WIDTH
    share = entry_share(x - goal_x, y - post_y, ball.x - x, ball.y - y)
    if share >= 0.0 and ball.z < GOAL_HEIGHT:
        away_x, away_y = x + share * (ball.x - x) - goal_x, y + share * (ball.y - y) - post_y
        ball.vx, ball.vy = reflected(ball.vx, ball.vy, away_x, away_y)
        ball.vz *= FRAME.bounce
        ball.x, ball.y = goal_x + away_x, post_y + away_y
        return
    share = entry_share(x - goal_x, z - GOAL_HEIGHT, ball.x - x, ball.z - z)
    if share >= 0.0 and abs(ball.y) < GOAL_HALF_WIDTH:
        away_x, away_z = x + share * (ball.x - x) - goal_x, z + share * (ball.z - z) - GOAL_HEIGHT
        ball.vx, ball.vz = reflected(ball.vx, ball.vz, away_x, away_z)
        ball.vy *= FRAME.bounce
        ball.x, ball.z = goal_x + away_x, GOAL_HEIGHT + away_z


@kernel
def entry_share(a, b, da, db):
    """Return the share in [0, 1] of the way (da, db) from (a, b) at which the frame at the origin is hit, else -1."""
    squared = da * da + db * db
    half = a * da + b * db
    outside = a * a + b * b - FRAME.reach * FRAME.reach
    discriminant = half * half - squared * outside
    if half >= 0.0 or outside < 0.0 or discriminant < 0.0:
        return -1.0
    share = (-half - math.sqrt(discriminant)) / squared
    return share if share <= 1.0 else -1.0


@kernel
def reflected(va, vb, a, b):
    """Return the velocity (va, vb) after a bounce off a post with surface normal (a, b)."""
    inward = (va * a + vb * b) / (a * a + b * b)
    return (va - 2.0 * inward * a) * FRAME.bounce, (vb - 2.0 * inward * b) * FRAME.bounce


@kernel
def rolled(speed, time):
    """Return the distance in m that a ball of this speed rolls in `time` seconds, with a mean deceleration."""
    slowing = GROUND.friction + MEAN_DRAG * speed * speed
    time = min(time, speed / slowing)
    return speed * time - 0.5 * slowing * time * time
