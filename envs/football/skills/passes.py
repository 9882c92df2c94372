"""Passes: their receiver, the receiver's later position, and the speed and height of the ball.

The rules and numbers are documented by Google Research Football. Read next: `skills.kicks`, where legs swing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import HIGH_PASS, LEFT, LONG_PASS, NOBODY
from regista.envs.football.physics.vectors import length
from regista.envs.football.skills.first_touch import difficulty
from regista.envs.football.skills.shots import bend
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Choice(NamedTuple):
    """Parameters for the receiver of a pass, and the receiver's later position."""

    farthest: float = 60.0  # m ahead of the passer, times the gauge: the point by which receivers are rated
    nearest: float = 1.0  # m, at least
    power_short: float = 0.7  # exponent of the gauge for a short pass
    power_long: float = 0.65
    power_high: float = 0.55
    scale: float = 70.0  # m
    weight: float = 0.8
    power: float = 0.8
    lead_longest: float = 0.7  # maximum s by which a receiver's run is extrapolated
    lead_power: float = 0.7
    lead_first: float = 0.3
    lead_per_metre: float = 0.05
    long_lead: float = 0.2  # share of the distance, towards the goal line that the passer attacks
    unaimed: float = 39.4  # m, length of a pass without a receiver


class Flight(NamedTuple):
    """How hard, high and precise a pass is."""

    speed: float = 36.0  # m/s
    base: float = 0.3  # share of the speed at distance 0
    ground_gain: float = 1.8  # shares of the speed added at the distance of full gain
    high_gain: float = 1.15
    gain_power: float = 1.4
    gain_distance: float = 60.0  # m
    ground_cap: float = 26.0  # m/s
    high_cap: float = 38.0  # m/s
    excess_lift: float = 0.25  # share of the speed above the cap that becomes m/s upwards
    excess_most: float = 10.0  # m/s above the cap that count, at most
    ball_helps: float = 0.5  # share of the speed of a ball played first-time that is added to the cap
    ground_lift: float = 0.11  # tangent of the elevation
    high_lift: float = 0.45  # tangent of the elevation of a high pass, near
    high_lift_less: float = 0.15  # less this for long passes
    ground_spin: float = 5.2  # m/s, in full at `full_spin`
    high_spin: float = -1.5  # m/s
    full_spin: float = 15.0  # m/s
    curl: float = 0.9 * -340.0  # rad/s per rad by which the fastest starts off towards the body; it curls back
    high_bend: float = 0.2  # factor of that for a high pass
    mirrored: float = 0.5  # share of passes whose lateral spin is reversed, which therefore rise
    scatter: float = 0.02  # rad to either side
    hard_scatter: float = 0.15  # quarter turns more for a ball that is hard to play
    hard_keep: float = 0.3
    hard_most: float = 0.5
    hard_weak: float = 0.3  # share of its speed that such a pass loses
    headed_from: float = 1.1  # m, height from which on a ball is headed
    headed_share: float = 0.6  # maximum speed of a header, as a share of the fastest pass


# The law is documented by Google Research Football, caps and scatter are fitted: `lab.benchmarks --suite grf`,
# family passes.
CHOICE, FLIGHT = Choice(), Flight()


@kernel
def aim_pass(match, i, ux, uy, gauge):
    """Aim along (ux, uy) at the receiver that GRF rates best; without a receiver, straight ahead."""
    player = match.players[i]
    mate = choose_mate(match, i, ux, uy, gauge)
    player.kick_mate = mate
    if mate == NOBODY:
        player.aim_x = player.x + CHOICE.unaimed * player.facing_x
        player.aim_y = player.y + CHOICE.unaimed * player.facing_y
        return
    player.aim_x, player.aim_y = place_of(match.ball, match.players[mate])
    if player.kick == LONG_PASS:
        lead = CHOICE.long_lead * length(player.aim_x - match.ball.x, player.aim_y - match.ball.y)
        player.aim_x += lead if player.team == LEFT else -lead


@kernel
def place_of(ball, mate):
    """Return the position at which a teammate will receive a pass of this ball."""
    time = CHOICE.lead_first + CHOICE.lead_per_metre * length(mate.x - ball.x, mate.y - ball.y)
    time = CHOICE.lead_longest * min(time, 1.0) ** CHOICE.lead_power
    return mate.x + time * mate.vx, mate.y + time * mate.vy


@kernel
def choose_mate(match, i, ux, uy, gauge):
    """Return the receiver of a pass along (ux, uy), near a point ahead and not far off the direction; -1 if none.

    `gauge` in [0, 1], from how long the button was held, puts the point further ahead.
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
        far = min(length(x - look_x, y - look_y) / CHOICE.scale, 1.0)
        rating = CHOICE.weight * far**CHOICE.power + off
        if rating < best_rating:
            best, best_rating = j, rating
    return best


@kernel
def look_ahead(kick, gauge):
    """Return the distance in m from the passer to the point ahead by which receivers are rated."""
    power = CHOICE.power_high if kick == HIGH_PASS else (CHOICE.power_long if kick == LONG_PASS else CHOICE.power_short)
    return max(CHOICE.farthest * gauge**power, CHOICE.nearest)


@kernel
def play_pass(match, player, ux, uy, distance):
    """Give the ball the velocity of a pass along (ux, uy) over this distance.

    GRF mirrors every other episode, except the spin, so lateral passes rise in these episodes.
    """
    ball = match.ball
    far = min(distance / FLIGHT.gain_distance, 1.0) ** FLIGHT.gain_power
    high = player.kick == HIGH_PASS
    needed = FLIGHT.speed * (FLIGHT.base + (FLIGHT.high_gain if high else FLIGHT.ground_gain) * far)
    cap = (FLIGHT.high_cap if high else FLIGHT.ground_cap) * (
        FLIGHT.headed_share if ball.z > FLIGHT.headed_from else 1.0
    )
    cap += FLIGHT.ball_helps * length(ball.vx - player.vx, ball.vy - player.vy)
    rise = (
        FLIGHT.high_lift - FLIGHT.high_lift_less * min(1.0, distance / FLIGHT.gain_distance)
        if high
        else FLIGHT.ground_lift
    )
    far_off, high_off, kept = difficulty(match, player)
    speed = min(needed, cap) * (1.0 - FLIGHT.hard_weak * far_off)
    flat = speed / math.sqrt(1.0 + rise * rise)
    excess = FLIGHT.excess_lift * min(max(needed - cap, 0.0), FLIGHT.excess_most)
    turn = min(FLIGHT.hard_scatter * (far_off + high_off) + FLIGHT.hard_keep * kept, FLIGHT.hard_most)
    off = (
        (FLIGHT.scatter / player.skill + 0.5 * math.pi * turn) * (2.0 * uniform(match) - 1.0) * match.engine.kick_spread
    )
    cosine, sine = math.cos(off), math.sin(off)
    wx, wy = ux * cosine - uy * sine, ux * sine + uy * cosine
    ball.vx, ball.vy, ball.vz = flat * wx, flat * wy, flat * rise + excess
    spin = (FLIGHT.high_spin if high else FLIGHT.ground_spin) * min(speed / FLIGHT.full_spin, 1.0)
    side = -1.0 if uniform(match) < FLIGHT.mirrored else 1.0
    ball.spin_x, ball.spin_y = spin * wx, side * spin * wy
    ball.curl = FLIGHT.curl * bend(ball, player, math.pi, FLIGHT.high_bend if high else 1.0)
