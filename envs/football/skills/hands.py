"""What a goalkeeper does with his hands: may he use them, does he hold the ball, where does a parried one go.

The rule of what is held is Google Research Football's; where parried balls go is measured of it. Read next:
`skills.contacts`.
"""

from __future__ import annotations

import math

from envs.football.constants import GK, NOBODY
from envs.football.physics.pitch import in_box_of, own_goal_x
from envs.football.physics.possession import lose_ball
from envs.football.physics.vectors import length
from envs.football.rules.offside import whistled
from envs.football.skills.touch import take
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import normal, uniform

# Catching
CATCH_TOP, CATCH_AGE, CATCH_FROM = 40.0, 1.5, 0.3  # m/s, s and the product of ease from which a ball is held
HANDS_HEIGHT, THROW_HEIGHT = 1.2, 1.9  # m, of a ball that is held, that is about to be thrown
HOLD_STEPS, HOLD_SPREAD = 3, 6  # steps for which a keeper keeps it at least, and how much they vary

# Parries: share of its speed that the ball keeps; tangents of the angle off straight back out
PARRY_KEEP, PARRY_KEEP_SPREAD, PARRY_LEAST, PARRY_MOST = 0.55, 0.16, 0.3, 0.9
PARRY_CARRY, PARRY_SPREAD = 0.25, 0.25  # of the ball's own sideways course; and how much it varies
TIPPED_CHANCE, TIPPED_ASIDE, TIPPED_SPREAD = 0.2, 0.8, 2.0  # of saves at full stretch, which go sideways
PARRY_LIFT, PARRY_LIFT_SPREAD = 0.7, 0.4  # m/s
PARRY_WAIT = 0.5  # s until the keeper can touch the ball again


@kernel
def has_hands(match, i):
    """Tell whether player i may use his hands: a keeper in his box, unless a mate has kicked the ball to him."""
    player = match.players[i]
    if player.role != GK or not in_box_of(player.team, player.x, player.y):
        return False
    last = match.last_touch
    return not match.was_kicked or last in (NOBODY, i) or match.players[last].team != player.team


@kernel
def can_hold(match, speed):
    """Tell whether a ball of this speed in m/s sticks in the hands: not a fast one, nor one just kicked."""
    fresh = max(1.0 - match.kick_age / CATCH_AGE, 0.0)
    return (1.0 - speed / CATCH_TOP) * (1.0 - fresh) >= CATCH_FROM


@kernel
def hold(match, i):
    """Give keeper i the ball in his hands; he turns his back on his goal, lest he carry it in."""
    take(match, i)
    if match.carrier != i:
        return
    player = match.players[i]
    player.facing_x, player.facing_y = -1.0 if own_goal_x(player.team) > 0.0 else 1.0, 0.0
    match.keeper_holding = i
    match.hold_wait = HOLD_STEPS + int(HOLD_SPREAD * uniform(match))
    carry_in_hands(match)


@kernel
def carry_in_hands(match):
    """Keep a held ball in its keeper's hands."""
    player, ball = match.players[match.keeper_holding], match.ball
    ball.x, ball.y = player.x + 0.3 * player.facing_x, player.y + 0.3 * player.facing_y
    ball.z = THROW_HEIGHT if match.kicker == match.keeper_holding else HANDS_HEIGHT
    ball.vx, ball.vy, ball.vz = player.vx, player.vy, 0.0


@kernel
def parry(match, i, stretched):
    """Let keeper i push the ball out again; at full stretch (`stretched`) it often only goes wide of him."""
    if whistled(match, i):
        return
    player, ball = match.players[i], match.ball
    lose_ball(match)
    fast = length(ball.vx, ball.vy)
    out = -1.0 if own_goal_x(player.team) > 0.0 else 1.0
    aside = PARRY_CARRY * ball.vy / max(abs(ball.vx), 1.0) + out * PARRY_SPREAD * normal(match)  # turned with the pitch
    if stretched and uniform(match) < TIPPED_CHANCE:
        side = ball.y - player.y
        aside = math.copysign(TIPPED_ASIDE + TIPPED_SPREAD * uniform(match), side if side != 0.0 else out)
    keep = min(max(PARRY_KEEP + PARRY_KEEP_SPREAD * normal(match), PARRY_LEAST), PARRY_MOST)
    size = math.sqrt(1.0 + aside * aside)
    ball.vx, ball.vy = keep * fast * out / size, keep * fast * aside / size
    ball.vz = PARRY_LIFT + PARRY_LIFT_SPREAD * normal(match)
    ball.spin_x, ball.spin_y, ball.curl = 0.0, 0.0, 0.0
    player.touch_wait = PARRY_WAIT
    match.last_touch = i
    match.was_kicked = False
    match.saver = NOBODY
