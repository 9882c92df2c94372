"""Shots blocked by an opponent in their way: by a leg already extended towards the ball, or by the body.

As measured in Google Research Football, where only shots are blocked. Read next: `skills.contacts`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import DT, NOBODY
from regista.envs.football.physics.possession import lose_ball
from regista.envs.football.physics.vectors import length, toward
from regista.envs.football.skills.saves import foresee
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Block(NamedTuple):
    """How near a shot must pass an opponent to be blocked, and the direction that it then takes.

    Fitted to 1280 shots past a lone back in Google Research Football; checked on 200 other scenes by `lab.benchmarks
    --suite grf`, family blocks.
    """

    until: float = 0.2  # s after the kick, in which blocks are possible
    leg_until: float = 0.045  # s after the kick, until which an extended leg can block,
    leg_gone: float = 0.12  # s, from which on the leg is back
    below: float = 1.9  # m above the ground, above which no block is possible
    body: float = 0.25  # m from the body's axis, within which a block has its maximum probability
    body_edge: float = 0.55  # m from the body's axis, beyond which a block is impossible
    leg: float = 0.7  # m added to both distances while the leg is extended
    leg_most: float = 0.55  # maximum probability while the leg is extended
    body_most: float = 0.95  # maximum probability later
    slow: float = 0.4  # share of its speed that the ball keeps, at least
    fast: float = 0.66  # share of its speed that the ball keeps, at most
    scatter: float = 0.6  # rad to either side of the direction straight away from the player
    rise: float = 9.0  # m/s upwards, at most; usually much less
    wait: float = 0.3  # s until the player can touch it again


BLOCK = Block()


@kernel
def is_shot(match):
    """Return whether the ball has just been struck, and not as a pass to a teammate."""
    return match.was_kicked and match.receiver == NOBODY and match.kick_age < BLOCK.until


@kernel
def passes_now(ball, player):
    """Return whether the ball, relative to a player, was nearest to the player within this frame."""
    vx, vy = ball.vx - player.vx, ball.vy - player.vy
    past = (ball.x - player.x) * vx + (ball.y - player.y) * vy
    return 0.0 <= past < (vx * vx + vy * vy) * DT


@kernel
def block(match, i, distance):
    """Let player i block a shot that passes at `distance` m, or miss it."""
    player, ball = match.players[i], match.ball
    leg = min(max((BLOCK.leg_gone - match.kick_age) / (BLOCK.leg_gone - BLOCK.leg_until), 0.0), 1.0)
    edge = BLOCK.body_edge + BLOCK.leg * leg
    if ball.z >= BLOCK.below or not passes_now(ball, player) or distance >= edge:
        return
    sure = BLOCK.body + BLOCK.leg * leg * leg
    most = BLOCK.leg_most if leg == 1.0 else BLOCK.body_most
    if uniform(match) >= most * min((edge - distance) / (edge - sure), 1.0):
        return
    bounce_back(match, player, edge)
    lose_ball(match)
    match.last_touch, match.was_kicked = i, False
    player.touch_wait = BLOCK.wait
    foresee(match, 1 - player.team)


@kernel
def bounce_back(match, player, edge):
    """Send the ball away from where a player blocked it, before its nearest point, `edge` m from the body's axis."""
    ball = match.ball
    aside_x, aside_y = ball.x - player.x, ball.y - player.y
    speed = length(ball.vx, ball.vy)
    back = math.sqrt(max(edge * edge - aside_x * aside_x - aside_y * aside_y, 0.0)) / (speed + 1e-9)
    away_x, away_y = toward(aside_x - back * ball.vx, aside_y - back * ball.vy)
    off = BLOCK.scatter * (2.0 * uniform(match) - 1.0)
    cosine, sine = math.cos(off), math.sin(off)
    speed *= BLOCK.slow + (BLOCK.fast - BLOCK.slow) * uniform(match)
    ball.vx, ball.vy = speed * (away_x * cosine - away_y * sine), speed * (away_x * sine + away_y * cosine)
    ball.vz = BLOCK.rise * uniform(match) ** 3
    ball.curl = 0.0
