"""What a goalkeeper does with his hands: may he use them, does he hold the ball, where does a parried one go.

The rule of what is held is Google Research Football's; where parried balls go is measured of it. Read next:
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

    top_speed: float = 40.0  # m/s, ease of holding falls to 0 by then
    age: float = 0.95  # s since a kick, by when all of the ease is there,
    dribbled: float = 1.2  # s since a carrier's touch, by when it is,
    surprise: float = 0.6  # growing slowly at first: the power of what is left of that time
    from_ease: float = 0.3  # product of both from which a ball may be held: measured of shots,
    fits: float = 0.5  # so often then, for there must be a way to get hold of it,
    surely: float = 0.65  # and always from here on
    height: float = 1.2  # m, of a ball that is held
    throw_height: float = 1.9  # m, of one that is about to be thrown
    spread: float = 6.0  # steps by which the time that he keeps it varies


class Parry(NamedTuple):
    """A ball that hands reach but do not hold, as documented: it goes the way that the keeper goes, and out.

    Of 662 measured ones the speeds are within 1.2 m/s of this, with his velocity as the ball came (medians).
    """

    ball: float = 0.3  # share of its speed that the ball keeps,
    run: float = 2.5  # and of his that it gets
    back: float = 0.1  # of its velocity, turned round, in the way that it goes,
    along: float = 2.0  # of his,
    out: float = 4.0  # m/s away from his goal,
    aside: float = 1.0  # and to either side at most
    lift: float = 1.2  # m/s
    wait: float = 0.5  # s until the keeper can touch the ball again


class Block(NamedTuple):
    """A shot that hits a body before it could do anything: it flies off as that is met, or as the body moves.

    As documented, but for where it is met: fitted to 94 measured shots from close by at a keeper who goes back.
    """

    ahead: float = 0.5  # m from who has kicked it to where it began
    fades: float = 0.2  # s since then, in which where it is met gives way to the body's own velocity,
    least: float = 0.2  # share that is left of it then;
    parts: float = 0.5  # how much of it there is: several parts of a body are met, from several sides
    wide: float = 0.55  # rad either way off straight back
    rise: float = 0.25  # tangent of the angle upwards,
    rise_spread: float = 0.35  # and how much that varies
    flat: float = 0.6  # share of the way up that is left
    off: float = 6.0  # m/s that way,
    bounce: float = 0.6  # and this share of the ball's speed more,
    back: float = 0.2  # less this share of its own velocity
    met_least: float = 0.8  # share of the ball that is met, at least: the rest of it goes on
    keep: float = 0.7  # of all this


# Fitted to measurements of Google Research Football: `regista benchmark --suite grf`, family keeper.
HOLD, PARRY, BLOCK = Hold(), Parry(), Block()
HOLD_STEPS = 3  # steps for which a keeper keeps the ball at least


@kernel
def has_hands(match, i):
    """Return whether player i may use his hands: a keeper in his box, unless a mate has kicked the ball to him."""
    player = match.players[i]
    if player.role != GK or not in_box_of(player.team, player.x, player.y):
        return False
    last = match.last_touch
    return not match.was_kicked or last in (NOBODY, i) or match.players[last].team != player.team


@kernel
def ease_of_holding(speed, age, window):
    """Return how easily a ball sticks in the hands, 0 to 1: this fast to them, in m/s, and played `age` s ago."""
    fresh = max(1.0 - age / window, 0.0) ** HOLD.surprise
    return (1.0 - speed / HOLD.top_speed) * (1.0 - fresh)


@kernel
def is_caught(match, speed):
    """Draw whether a ball that was kicked sticks in the hands: not a fast one, nor one just kicked."""
    ease = ease_of_holding(speed, match.kick_age, HOLD.age)
    if ease < HOLD.from_ease:
        return False
    surely = (ease - HOLD.from_ease) / (HOLD.surely - HOLD.from_ease)
    return uniform(match) < HOLD.fits + (1.0 - HOLD.fits) * surely


@kernel
def is_caught_off_feet(speed, age):
    """Return whether a ball sticks in the hands that is this fast to them, in m/s, and was played `age` s ago."""
    return ease_of_holding(speed, age, HOLD.dribbled) >= HOLD.from_ease


@kernel
def hold(match, i):
    """Give keeper i the ball in his hands; he turns his back on his goal, lest he carry it in."""
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
    """Knock the ball out off the hands of a keeper who goes this way, in m/s: the harder, the faster he goes."""
    ball = match.ball
    out = -math.copysign(PARRY.out, own_goal_x(player.team))
    aside = out / PARRY.out * PARRY.aside * (2.0 * uniform(match) - 1.0)  # turned with the pitch
    to_x, to_y = toward(
        PARRY.along * run_x - PARRY.back * ball.vx + out, PARRY.along * run_y - PARRY.back * ball.vy + aside
    )
    speed = PARRY.ball * length(ball.vx, ball.vy) + PARRY.run * length(run_x, run_y)
    ball.vx, ball.vy = speed * to_x, speed * to_y


@kernel
def bounce_off(match, player):
    """Let a ball that has just been kicked fly off a player's body: on with it, if he goes the same way."""
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
