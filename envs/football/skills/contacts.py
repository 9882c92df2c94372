"""Meetings of players with a ball that is not theirs: traps, tackles, claims by hand, saves and blocks.

Read next: `skills.tackles`, then `rules.referee`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from envs.football.constants import GK, NOBODY, NORMAL, STEP
from envs.football.physics.possession import ball_speed
from envs.football.physics.vectors import length, toward
from envs.football.skills.first_touch import cushion
from envs.football.skills.hands import can_hold, has_hands, hold, parry
from envs.football.skills.kicks import kick_first_time
from envs.football.skills.saves import DIVE, foresee
from envs.football.skills.tackles import (
    STANDING,
    goes_for_ball,
    in_tackle_reach,
    slide_into,
    tackle,
    within_reach,
)
from envs.football.skills.touch import take
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform


class Trap(NamedTuple):
    """Bringing a free ball under control."""

    reach: float = 0.75  # m
    below: float = 1.9  # m
    body_reach: float = 0.3  # m, to a shot too sudden to put out a leg:
    sudden_age: float = 0.25  # s since it was struck, at most,
    sudden_speed: float = 22.0  # m/s, at least
    first_time_from: float = 3.0  # m/s, slower balls are taken to the feet and kicked with a full swing
    header_from: float = 0.9  # m


class Claim(NamedTuple):
    """A keeper at the feet of a carrier, or at a free ball."""

    reach: float = 0.95  # m
    below: float = 2.2  # m
    standing: float = 0.6  # chance against a carrier who stands
    sure: float = 1.42  # against one who runs,
    hurried: float = 0.1  # less per m/s,
    most: float = 0.95  # but at most
    wait: float = 1.2  # s when beaten, until he can touch the ball again
    down: float = 1.0  # s on the ground then; a carrier who stands does not leave him there
    feet: float = 0.85  # of the chance that is left with the feet alone
    swerve: float = 10.0  # m/s across his reach at which he cannot have it
    robbed_wait: float = 0.7  # s until a carrier who has lost the ball can touch it again


class Poke(NamedTuple):
    """A ball knocked loose with the feet; documented of Google Research Football."""

    run: float = 0.5  # share of the keeper's velocity that it gets,
    speed: float = 4.0  # and m/s away from him,
    rise: float = 0.5  # and m/s up,
    rise_spread: float = 1.0  # and as many more at most
    wait: float = 0.4  # s until he can touch it again


class Catch(NamedTuple):
    """What becomes of a saved shot."""

    below: float = 2.8  # m, height of a ball that he can save
    easy: float = 8.0  # m/s, slower balls always stick
    near: float = 0.9  # m: on the spot
    fits: float = 0.6  # chance that a ball slow enough sticks, near
    diving: float = 0.2  # and at a stretch
    easier: float = 0.75  # s after the kick, from where on more balls stick
    ease: float = 0.2  # s more, until all do
    block_down: float = 0.3  # s on the ground after a block on the spot
    dive_down: float = 1.1  # s, after a dive


# Fitted to measurements of Google Research Football: `regista benchmark --suite grf`, families keeper and passes.
TRAP, CLAIM, POKE, CATCH = Trap(), Claim(), Poke(), Catch()
MEETING = 1.7  # m from the body to the ball, beyond which nobody does anything to it
_COIN, _ONE = np.uint64(40), np.uint64(1)  # a bit of the random stream's state that nothing is drawn from


@kernel
def reachable(match):
    """Return a bit for every player who may meet the ball within a step."""
    ball = match.ball
    reach = MEETING + STEP * (8.0 + math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy))
    bits = 0
    for i in range(match.num_players):
        player = match.players[i]
        dx, dy = ball.x - player.x, ball.y - player.y
        if dx * dx + dy * dy < reach * reach:
            bits |= 1 << i
    return bits


@kernel
def meet_ball(match, bits):
    """Let every player named in `bits` try for the ball in this frame.

    Who goes first alternates between steps, and between matches, so that no side is sooner in the same scene.
    """
    turned = (match.step + int(match.random >> _COIN & _ONE)) % 2 == 1
    for k in range(match.num_players):
        i = match.num_players - 1 - k if turned else k
        if match.game_mode != NORMAL:
            return
        if bits >> i & 1 == 0 or match.keeper_holding != NOBODY or match.carrier == i:
            continue
        player = match.players[i]
        if player.touch_wait > 0.0 or (player.down_wait > 0.0 and not player.is_sliding):
            continue
        dx, dy = match.ball.x - player.x, match.ball.y - player.y
        squared = dx * dx + dy * dy
        if squared < MEETING * MEETING:
            meet(match, i, math.sqrt(squared))


@kernel
def meet(match, i, distance):
    """Let player i, this far from the ball, do what suits: save, claim, tackle, or trap."""
    player, ball = match.players[i], match.ball
    if match.saver == i:
        if match.save_wait < STEP and distance < DIVE.arm:
            save(match, i)
    elif match.carrier != NOBODY:
        if match.players[match.carrier].team != player.team:
            challenge(match, i, distance)
    elif player.role == GK and distance < CLAIM.reach and ball.z < CLAIM.below and has_hands(match, i):
        catch(match, i)
    elif distance < (TRAP.body_reach if too_sudden(match) else TRAP.reach) and ball.z < TRAP.below:
        trap(match, i)


@kernel
def too_sudden(match):
    """Return whether the ball has just been struck so hard that it meets nobody but whom it hits."""
    return match.was_kicked and match.kick_age < TRAP.sudden_age and ball_speed(match.ball) > TRAP.sudden_speed


@kernel
def challenge(match, i, distance):
    """Let player i, this far from the ball, try to take it off the carrier."""
    player, ball = match.players[i], match.ball
    if player.role == GK and not player.is_sliding:
        if distance < CLAIM.reach and ball.z < (CLAIM.below if has_hands(match, i) else TRAP.header_from):
            claim(match, i)
    elif player.is_sliding:
        slide_into(match, i, distance)
    elif in_tackle_reach(match, i, distance) and goes_for_ball(match, i, distance):
        tackle(match, i)


@kernel
def trap(match, i):
    """Let player i bring a free ball under control, or play it on at once if he has asked for a kick."""
    player = match.players[i]
    if player.kick_ready and player.kick != 0 and ball_speed(match.ball) > TRAP.first_time_from:
        kick_first_time(match, i)
        return
    cushion(match, i)
    if match.carrier == NOBODY and match.game_mode == NORMAL:  # it jumped off him, perhaps towards a goal
        foresee(match, player.team)


@kernel
def claim(match, i):
    """Let keeper i try to take the ball off the carrier's feet; beaten, he lies on the ground for a while."""
    player, carrier = match.players[i], match.players[match.carrier]
    speed = length(carrier.vx, carrier.vy)
    stands = speed < STANDING
    chance = CLAIM.standing
    if not stands:
        chance = min(CLAIM.sure - CLAIM.hurried * speed, CLAIM.most)
        chance *= (0.5 + 0.5 * player.skill) * within_reach(match, i, CLAIM.swerve)
    hands = has_hands(match, i)
    if uniform(match) < (chance if hands else CLAIM.feet * chance):
        carrier.touch_wait = CLAIM.robbed_wait
        if hands:
            hold(match, i)
        else:
            poke(match, i)
        return
    player.touch_wait, player.down_wait = CLAIM.wait, 0.0 if stands else CLAIM.down


@kernel
def poke(match, i):
    """Let keeper i knock the ball loose with his feet, away from him."""
    player, ball = match.players[i], match.ball
    take(match, i)
    if match.carrier != i:
        return
    away_x, away_y = toward(ball.x - player.x, ball.y - player.y)
    ball.vx, ball.vy = POKE.run * player.vx + POKE.speed * away_x, POKE.run * player.vy + POKE.speed * away_y
    ball.vz = POKE.rise + POKE.rise_spread * uniform(match)
    match.carrier = NOBODY
    player.touch_wait = POKE.wait


@kernel
def catch(match, i):
    """Let keeper i take a free ball with his hands, or parry it if it comes too hard."""
    player, ball = match.players[i], match.ball
    fast = length(ball.vx - player.vx, ball.vy - player.vy)
    if fast < CATCH.easy or can_hold(match, fast):
        hold(match, i)
    else:
        parry(match, i, False)


@kernel
def save(match, i):
    """Carry out what was drawn when the shot was taken: a catch, a parry, or nothing."""
    player, ball = match.players[i], match.ball
    near = match.save_gap < CATCH.near
    match.saver = NOBODY
    if not match.save_succeeds or ball.z > CATCH.below:
        player.touch_wait, player.down_wait = CLAIM.wait, CATCH.dive_down
        return
    late = min(max((match.kick_age - CATCH.easier) / CATCH.ease, 0.0), 1.0)
    fits = CATCH.fits if near else CATCH.diving
    sticks = uniform(match) < fits + (1.0 - fits) * late
    if sticks and can_hold(match, length(ball.vx, ball.vy)) and has_hands(match, i):
        hold(match, i)
        return
    parry(match, i, not near)
    player.down_wait = CATCH.block_down if near else CATCH.dive_down
