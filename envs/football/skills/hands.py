"""A goalkeeper's hands: whether they may be used, whether they catch the ball, and where a parried ball goes.

The rule of catches is Google Research Football's; the directions of parried balls are measured in it. Read next:
`skills.contacts`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import GK, NOBODY
from regista.envs.football.physics.pitch import in_box_of, own_goal_x
from regista.envs.football.physics.possession import lose_ball
from regista.envs.football.physics.vectors import apart, length, toward
from regista.envs.football.rules.offside import whistled
from regista.envs.football.skills.saves import SAVE
from regista.envs.football.skills.touch import take
from regista.kernels.jit import kernel
from regista.kernels.rng import normal, uniform


class Hold(NamedTuple):
    """Balls in a keeper's hands."""

    top_speed: float = 40.0  # m/s, at which the ease of catching is 0
    age: float = 0.95  # s after a kick, at which the ease is full
    dribbled: float = 1.2  # s after a carrier's touch, at which the ease is full
    surprise: float = 0.6  # exponent of the share of that time that is left: the ease grows slowly at first
    from_ease: float = 0.3  # product of both factors from which on a ball may be caught, measured with shots
    fits: float = 0.5  # probability of a catch at this product, since the catch also needs a suitable movement
    surely: float = 0.65  # product from which on the ball is always caught
    height: float = 1.2  # m, height of a held ball
    throw_height: float = 1.9  # m, height of a ball that is about to be thrown
    spread: float = 6.0  # steps, range of the holding time


class Parry(NamedTuple):
    """A ball that hands reach but do not catch, as documented: it goes in the keeper's direction and away from goal.

    Of 662 measured parries the speeds are within 1.2 m/s of this, with the keeper's velocity before contact (medians).
    """

    ball: float = 0.3  # share of its speed that the ball keeps
    run: float = 2.5  # factor of the keeper's velocity in the ball's,
    back: float = 0.1  # weight of the ball's velocity, reversed, in the direction
    along: float = 2.0  # weight of the keeper's velocity in the direction
    out: float = 4.0  # m/s away from the own goal in the direction,
    aside: float = 1.0  # and to either side, at most
    lift: float = 1.2  # m/s
    wait: float = 0.5  # s until the keeper can touch the ball again


class Block(NamedTuple):
    """A shot that hits a body before any reaction: it bounces off by the point of contact, or by the body's motion.

    As documented, except the point of contact: fitted to 94 measured shots from close by at a retreating keeper.
    """

    ahead: float = 0.5  # m from the kicker to the ball's first position
    fades: float = 0.2  # s after the kick, in which the point of contact gives way to the body's own velocity
    least: float = 0.2  # share of the point of contact that is left
    parts: float = 0.5  # weight of the point of contact: several parts of a body are hit, from several sides
    wide: float = 0.55  # rad, standard deviation from the direction straight back
    rise: float = 0.25  # mean tangent of the angle upwards
    rise_spread: float = 0.35  # standard deviation of this tangent
    flat: float = 0.6  # share of the upward component that is left
    off: float = 6.0  # m/s in the direction of the bounce,
    bounce: float = 0.6  # and this share of the ball's speed,
    back: float = 0.2  # less this share of the ball's own velocity
    met_least: float = 0.8  # minimum share of the ball that is hit; the rest of its velocity continues
    keep: float = 0.7  # factor of the result


# Fitted to measurements of Google Research Football: `lab.benchmarks --suite grf`, family keeper.
HOLD, PARRY, BLOCK = Hold(), Parry(), Block()
HOLD_STEPS = 3  # minimum number of steps for which a keeper holds the ball


@kernel
def has_hands(match, i):
    """Return whether player i may use hands: a keeper in the own box, unless a teammate has kicked the ball back."""
    player = match.players[i]
    if player.role != GK or not in_box_of(player.team, player.x, player.y):
        return False
    last = match.last_touch
    return not match.was_kicked or last in (NOBODY, i) or match.players[last].team != player.team


@kernel
def ease_of_holding(speed, age, window):
    """Return the ease of catching a ball, 0 to 1, at this relative speed in m/s, played `age` s ago."""
    fresh = max(1.0 - age / window, 0.0) ** HOLD.surprise
    return (1.0 - speed / HOLD.top_speed) * (1.0 - fresh)


@kernel
def is_caught(match, speed):
    """Draw whether a kicked ball is caught; fast balls and balls just kicked are not."""
    ease = ease_of_holding(speed, match.kick_age, HOLD.age)
    if ease < HOLD.from_ease:
        return False
    surely = (ease - HOLD.from_ease) / (HOLD.surely - HOLD.from_ease)
    return uniform(match) < HOLD.fits + (1.0 - HOLD.fits) * surely


@kernel
def is_caught_off_feet(speed, age):
    """Return whether a carrier's ball is caught at this relative speed in m/s, played `age` s ago."""
    return ease_of_holding(speed, age, HOLD.dribbled) >= HOLD.from_ease


@kernel
def hold(match, i):
    """Put the ball into the hands of keeper i, who faces away from the own goal so as not to carry the ball in."""
    take(match, i)
    if match.carrier != i:
        return
    player = match.players[i]
    player.facing_x, player.facing_y = -1.0 if own_goal_x(player.team) > 0.0 else 1.0, 0.0
    match.keeper_holding = i
    match.hold_wait = HOLD_STEPS + int(HOLD.spread * uniform(match))
    carry_in_hands(match)


@kernel
def carry_in_hands(match):
    """Keep a held ball in its keeper's hands."""
    player, ball = match.players[match.keeper_holding], match.ball
    ball.x, ball.y = player.x + 0.3 * player.facing_x, player.y + 0.3 * player.facing_y
    ball.z = HOLD.throw_height if match.kicker == match.keeper_holding else HOLD.height
    ball.vx, ball.vy, ball.vz = player.vx, player.vy, 0.0


@kernel
def parry(match, i):
    """Let keeper i push the ball away, or be hit by it."""
    if whistled(match, i):
        return
    player, ball = match.players[i], match.ball
    lose_ball(match)
    if match.was_kicked and match.kick_age < SAVE.sudden and match.last_touch != NOBODY:
        bounce_off(match, player)
    else:
        knock_out(match, player, player.vx, player.vy)
        ball.vz = PARRY.lift
    ball.spin_x, ball.spin_y, ball.curl = 0.0, 0.0, 0.0
    player.touch_wait = PARRY.wait
    match.last_touch = i
    match.was_kicked = False
    match.saver = NOBODY


@kernel
def knock_out(match, player, run_x, run_y):
    """Knock the ball off the hands of a keeper with velocity (run_x, run_y) in m/s, harder if the keeper is faster."""
    ball = match.ball
    out = -math.copysign(PARRY.out, own_goal_x(player.team))
    aside = out / PARRY.out * PARRY.aside * (2.0 * uniform(match) - 1.0)  # rotated with the pitch
    to_x, to_y = toward(
        PARRY.along * run_x - PARRY.back * ball.vx + out, PARRY.along * run_y - PARRY.back * ball.vy + aside
    )
    speed = PARRY.ball * length(ball.vx, ball.vy) + PARRY.run * length(run_x, run_y)
    ball.vx, ball.vy = speed * to_x, speed * to_y


@kernel
def bounce_off(match, player):
    """Let a ball that has just been kicked bounce off a player's body, or continue in its direction."""
    ball = match.ball
    speed = math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy + ball.vz * ball.vz)
    flight = (apart(player, match.players[match.last_touch]) - BLOCK.ahead) / max(speed, 1.0)
    met = BLOCK.least + (1.0 - BLOCK.least) * min(max(1.0 - flight / BLOCK.fades, 0.0), 1.0)
    ux, uy = toward(ball.vx, ball.vy)
    turn = BLOCK.wide * normal(match)
    cosine, sine = math.cos(turn), math.sin(turn)
    x = (1.0 - met) * player.vx + BLOCK.parts * met * (sine * uy - cosine * ux)
    y = (1.0 - met) * player.vy - BLOCK.parts * met * (sine * ux + cosine * uy)
    z = BLOCK.flat * BLOCK.parts * met * (BLOCK.rise + BLOCK.rise_spread * normal(match))
    off = (BLOCK.off + BLOCK.bounce * speed) / (math.sqrt(x * x + y * y + z * z) + 1e-9)
    met = BLOCK.met_least + (1.0 - BLOCK.met_least) * uniform(match)
    on = 1.0 - met - met * BLOCK.back
    x, y, z = met * off * x + on * ball.vx, met * off * y + on * ball.vy, met * off * z + on * ball.vz
    keep = BLOCK.keep * min(speed / (math.sqrt(x * x + y * y + z * z) + 1e-9), 1.0)
    ball.vx, ball.vy, ball.vz = keep * x, keep * y, keep * z
