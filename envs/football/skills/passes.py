"""Passes: which mate they are for, where he will be, and how hard and high the ball is played.

The rules and numbers are those documented of Google Research Football. Read next: `skills.kicks`, where legs swing.
"""

from __future__ import annotations

import math

from envs.football.constants import HIGH_PASS, LEFT, LONG_PASS, NOBODY
from envs.football.physics.vectors import length
from envs.football.skills.first_touch import difficulty
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

# Which mate
LOOK_FARTHEST, LOOK_NEAREST = 60.0, 1.0  # m ahead of the passer, the place that mates are rated by, by the gauge
LOOK_POWER_SHORT, LOOK_POWER_LONG, LOOK_POWER_HIGH = 0.7, 0.65, 0.55  # of the gauge
RATE_SCALE, RATE_WEIGHT, RATE_POWER = 70.0, 0.8, 0.8
LEAD_LONGEST, LEAD_POWER, LEAD_FIRST, LEAD_PER_METRE = 0.7, 0.7, 0.3, 0.05  # s by which a mate's run is led
LONG_LEAD = 0.2  # of the distance, towards the goal line that the passer attacks
UNAIMED_PASS = 39.4  # m, a pass when there is no mate

# How
PASS_SPEED, PASS_BASE = 36.0, 0.3  # m/s; share of it at no distance
GROUND_GAIN, HIGH_GAIN, GAIN_POWER, GAIN_DISTANCE = 1.8, 1.15, 1.4, 60.0  # m
GROUND_CAP, HIGH_CAP, EXCESS_LIFT, EXCESS_MOST = 26.0, 38.0, 0.25, 10.0
BALL_HELPS = 0.5  # of the speed of a ball played without a trap adds to the cap
GROUND_LIFT = 0.11  # tangent of the elevation
HIGH_LIFT, HIGH_LIFT_LESS = 0.45, 0.15  # for near and, less this, for far ones
GROUND_SPIN, HIGH_SPIN, FULL_SPIN = 5.2, -1.5, 15.0  # m/s, at this speed and more
PASS_SCATTER = 0.02  # rad either way
HARD_SCATTER, HARD_KEEP, HARD_MOST = 0.15, 0.3, 0.5  # quarter turns more of a ball that is hard to play
HARD_WEAK = 0.3  # of its speed that a pass of such a ball loses
HEADED_FROM, HEADED_SHARE = 1.1, 0.6  # m; of the fastest pass that a header reaches


@kernel
def aim_pass(match, i, ux, uy, gauge):
    """Aim along (ux, uy) at the mate whom the original's rating prefers; without one, straight ahead."""
    player = match.players[i]
    mate = choose_mate(match, i, ux, uy, gauge)
    player.kick_mate = mate
    if mate == NOBODY:
        player.aim_x = player.x + UNAIMED_PASS * player.facing_x
        player.aim_y = player.y + UNAIMED_PASS * player.facing_y
        return
    player.aim_x, player.aim_y = place_of(match.ball, match.players[mate])
    if player.kick == LONG_PASS:
        lead = LONG_LEAD * length(player.aim_x - match.ball.x, player.aim_y - match.ball.y)
        player.aim_x += lead if player.team == LEFT else -lead


@kernel
def place_of(ball, mate):
    """Where a mate will be when he takes a pass of this ball."""
    time = LEAD_FIRST + LEAD_PER_METRE * length(mate.x - ball.x, mate.y - ball.y)
    time = LEAD_LONGEST * min(time, 1.0) ** LEAD_POWER
    return mate.x + time * mate.vx, mate.y + time * mate.vy


@kernel
def choose_mate(match, i, ux, uy, gauge):
    """Return the mate for a pass along (ux, uy): near a point ahead and not far off the direction; -1 without one.

    `gauge` in [0, 1], how long the button was held, puts the point further ahead.
    """
    player, ball = match.players[i], match.ball
    look = look_ahead(player.kick, gauge)
    look_x, look_y = ball.x + look * ux, ball.y + look * uy
    best, best_rating = NOBODY, math.inf
    for j in range(match.num_players):
        mate = match.players[j]
        if j == i or mate.team != player.team or mate.has_left:
            continue
        x, y = place_of(ball, mate)
        dx, dy = x - ball.x, y - ball.y
        off = abs(math.atan2(ux * dy - uy * dx, ux * dx + uy * dy)) / math.pi
        far = min(length(x - look_x, y - look_y) / RATE_SCALE, 1.0)
        rating = RATE_WEIGHT * far**RATE_POWER + off
        if rating < best_rating:
            best, best_rating = j, rating
    return best


@kernel
def look_ahead(kick, gauge):
    """Metres ahead of the passer of the place that mates are rated by."""
    power = LOOK_POWER_HIGH if kick == HIGH_PASS else (LOOK_POWER_LONG if kick == LONG_PASS else LOOK_POWER_SHORT)
    return max(LOOK_FARTHEST * gauge**power, LOOK_NEAREST)


@kernel
def play_pass(match, player, ux, uy, distance):
    """Give the ball the velocity of a pass along (ux, uy) over this distance."""
    ball = match.ball
    far = min(distance / GAIN_DISTANCE, 1.0) ** GAIN_POWER
    high = player.kick == HIGH_PASS
    wanted = PASS_SPEED * (PASS_BASE + (HIGH_GAIN if high else GROUND_GAIN) * far)
    cap = (HIGH_CAP if high else GROUND_CAP) * (HEADED_SHARE if ball.z > HEADED_FROM else 1.0)
    cap += BALL_HELPS * length(ball.vx - player.vx, ball.vy - player.vy)
    rise = HIGH_LIFT - HIGH_LIFT_LESS * min(1.0, distance / GAIN_DISTANCE) if high else GROUND_LIFT
    far_off, high_off, kept = difficulty(match, player)
    speed = min(wanted, cap) * (1.0 - HARD_WEAK * far_off)
    flat = speed / math.sqrt(1.0 + rise * rise)
    excess = EXCESS_LIFT * min(max(wanted - cap, 0.0), EXCESS_MOST)
    turn = min(HARD_SCATTER * (far_off + high_off) + HARD_KEEP * kept, HARD_MOST)
    off = (PASS_SCATTER / player.skill + 0.5 * math.pi * turn) * (2.0 * uniform(match) - 1.0)
    cosine, sine = math.cos(off), math.sin(off)
    wx, wy = ux * cosine - uy * sine, ux * sine + uy * cosine
    ball.vx, ball.vy, ball.vz = flat * wx, flat * wy, flat * rise + excess
    spin = (HIGH_SPIN if high else GROUND_SPIN) * min(speed / FULL_SPIN, 1.0)
    ball.spin_x, ball.spin_y, ball.curl = spin * wx, spin * wy, 0.0
