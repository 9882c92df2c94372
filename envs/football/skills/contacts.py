"""Contacts of players with a free ball or another player's ball: traps, tackles, claims by hand, saves and blocks.

Read next: `skills.tackles`, then `rules.referee`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from regista.envs.football.constants import GK, KICK_PATIENCE, NOBODY, NORMAL, SHOT, STEP
from regista.envs.football.physics.bodies import advance_players
from regista.envs.football.physics.possession import ball_speed, forget_kick
from regista.envs.football.physics.vectors import apart, length, toward
from regista.envs.football.skills.blocks import block, is_shot
from regista.envs.football.skills.first_touch import cushion, lets_come
from regista.envs.football.skills.hands import PARRY, has_hands, hold, is_caught, is_caught_off_feet, knock_out, parry
from regista.envs.football.skills.kicks import AFTER_KICK, kick_first_time
from regista.envs.football.skills.saves import DIVE, foresee
from regista.envs.football.skills.tackles import (
    STANDING,
    frontal,
    goes_for_ball,
    in_tackle_reach,
    slide_into,
    tackle,
    within_reach,
)
from regista.envs.football.skills.touch import take
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Trap(NamedTuple):
    """Bringing a free ball under control."""

    reach: float = 0.75  # m
    leg: float = 0.83  # m, for a standing player with no direction held, who puts out a leg
    below: float = 1.9  # m
    sudden_age: float = 0.25  # s after a ball was struck, in which no player extends a leg to it
    sudden_speed: float = 22.0  # m/s, minimum speed of such a ball
    first_time_from: float = 3.0  # m/s; slower balls are brought to the feet and kicked with a full swing
    header_from: float = 0.9  # m, height above which a ball is headed
    volley_below: float = 0.55  # m; a lower ball is shot first-time, a higher ball is stopped first
    volley_above: float = 1.4  # m; a still higher ball is headed
    volley: float = 0.15  # share of balls between these heights that are shot first-time
    volley_run: float = 3.3  # m/s to which the swing slows a runner down
    settles: float = 0.25  # s in which a ball stopped for a shot drops before the leg swings


class MatesBall(NamedTuple):
    """A teammate's ball, for a player who has requested a kick; checked against random meetings in both engines."""

    reach: float = 0.7  # m
    pushed: float = 0.03  # m of being pushed, beyond which the player swings; otherwise once the ball comes no nearer
    missed: float = 0.3  # share of a swing that is subtracted; if nothing is left, the player misses
    best: float = 1.3  # range of the random share before this; more than 1 counts as 1
    stops: float = 0.4  # s after the request, in which the player stops the ball first
    robbed_wait: float = 0.3  # s until the teammate can touch the ball again


class Claim(NamedTuple):
    """A keeper at the feet of a carrier, or at a free ball."""

    reach: float = 0.95  # m
    below: float = 2.2  # m
    standing: float = 0.6  # chance against a standing carrier
    sure: float = 1.95  # chance against a running carrier,
    hurried: float = 0.145  # less this per m/s of the carrier,
    most: float = 1.08  # but at most
    wait: float = 0.7  # s until a beaten keeper can touch the ball again
    down: float = 0.6  # s on the ground, for a beaten keeper; not against a standing carrier
    swerve: float = 25.0  # m/s across the keeper's reach at which the ball cannot be won
    robbed_wait: float = 0.7  # s until a robbed carrier can touch the ball again
    bumped: float = 0.45  # s for which a carrier who gets past the keeper stumbles


class Feet(NamedTuple):
    """A keeper without hands at the feet of a carrier: slides and kicks the ball far away, or pokes it loose.

    The keeper won 116 of 120 measured meetings outside the box, 72 in a slide. Pokes are as documented, kicks fitted.
    """

    chance: float = 0.96  # chance to win the ball
    swerve: float = 6.0  # m/s across the keeper's reach, at which the ball cannot be won; half of it has little effect
    front: float = 0.5  # minimum cosine of the angle from the carrier's front; below it, the keeper tackles
    slide_reach: float = 0.95  # m from the body to a ball that the slide plays
    slides: float = 0.63  # share of wins that are slides
    poke_run: float = 0.5  # share of the keeper's velocity that a poked ball gets
    poke_speed: float = 4.0  # m/s of it away from the keeper
    poke_rise: float = 0.5  # m/s of it upwards,
    poke_rise_spread: float = 1.0  # and at most this more
    slow: float = 9.0  # m/s of a ball kicked out of a slide, at least
    fast: float = 15.0  # m/s, at most
    rise: float = 0.78  # share of this speed that is added upwards
    kick_run: float = 0.3  # s of the keeper's run by which the kick is deflected
    wait: float = 0.5  # s until the keeper can touch the ball again
    due: float = 0.2  # s since the carrier's touch, after which the kicked ball hits the carrier and bounces off
    stopped: float = 0.7  # share of its speed that this ball keeps
    height: float = 0.6  # m, height of this ball
    drop: float = 1.8  # m/s downwards
    blunted: float = 0.3  # share of the carrier's velocity that is left after running into the slide
    stumble: float = 0.15  # s until the carrier accelerates again, at least,
    stumble_spread: float = 0.27  # s more, at most


class Deflect(NamedTuple):
    """A ball off a carrier's feet that a keeper's hands reach but do not catch: `hands.Parry`, rarely a clean one.

    Fitted to 190 measured meetings.
    """

    run_least: float = 0.25  # share of the keeper's velocity that is left at the contact, at least,
    run_more: float = 1.05  # and more, at most,
    run_power: float = 2.5  # with this exponent of a uniform draw, so usually little
    clean: float = 0.4  # share of balls met cleanly; the others keep a part of their velocity
    knocked_on: float = 0.6  # m between the carrier and the ball, beyond which the keeper may slide
    slides: float = 0.55  # probability of this slide
    down: float = 0.6  # s on the ground
    wait: float = 1.0  # s until the keeper can touch the ball again
    robbed_wait: float = 0.5  # s until the carrier can touch the ball again


class Catch(NamedTuple):
    """The outcome of a saved shot."""

    below: float = 2.8  # m, height of a ball that can be saved
    easy: float = 8.0  # m/s; slower balls are always caught
    near: float = 0.9  # m; no dive is needed within this distance
    block_down: float = 0.3  # s on the ground after a block without a dive
    dive_down: float = 1.1  # s on the ground after a dive


# Fitted to measurements of Google Research Football: `lab.benchmarks --suite grf`, families keeper and passes.
TRAP, MATES_BALL, CLAIM, FEET, DEFLECT, CATCH = Trap(), MatesBall(), Claim(), Feet(), Deflect(), Catch()
MEETING = 1.7  # m from the body to the ball, beyond which there is no contact
_COIN, _ONE = np.uint64(40), np.uint64(1)  # a bit of the random stream's state that no draw uses


@kernel
def reachable(match):
    """Return the bits of all players who may meet the ball within a step."""
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
def meet_ball(match, bits, far, behind):
    """Let every player in `bits` try for the ball in this frame.

    The order alternates between steps, and between matches, so that no side is favored in the same scene. A player may
    read the positions of others, so the players in the bits `far`, which are `behind` frames behind, are moved first.
    Return the number of frames left.
    """
    turned = (match.step + int(match.random >> _COIN & _ONE)) % 2 == 1
    for k in range(match.num_players):
        i = match.num_players - 1 - k if turned else k
        if bits >> i & 1 == 0:
            continue
        if match.game_mode != NORMAL:
            break
        if match.keeper_holding != NOBODY or match.carrier == i:
            continue
        player = match.players[i]
        busy = player.touch_wait > 0.0 or (player.down_wait > 0.0 and not player.is_sliding)
        if busy and match.saver != i:
            continue
        dx, dy = match.ball.x - player.x, match.ball.y - player.y
        squared = dx * dx + dy * dy
        if squared < MEETING * MEETING:
            behind = advance_players(match, far, behind)
            meet(match, i, math.sqrt(squared))
    return behind


@kernel
def meet(match, i, distance):
    """Let player i, at `distance` m from the ball, save, claim, tackle or trap it, whichever applies."""
    player, ball = match.players[i], match.ball
    if match.saver == i:
        if match.save_wait < STEP and distance < DIVE.arm:
            save(match, i)
    elif match.carrier != NOBODY:
        if match.players[match.carrier].team != player.team:
            challenge(match, i, distance)
        elif player.kick_ready and meets_mates_ball(player, ball, distance):
            kick_mates_ball(match, i)
    elif player.role == GK and distance < CLAIM.reach and ball.z < CLAIM.below and has_hands(match, i):
        catch(match, i)
    elif is_shot(match) and match.players[match.last_touch].team != player.team:
        block(match, i, distance)
    elif not too_sudden(match) and distance < reach_of(player) and ball.z < TRAP.below and not lets_come(ball, player):
        trap(match, i)


@kernel
def reach_of(player):
    """Return the distance in m from the body within which a player brings a free ball under control."""
    stands = player.direction == 0 and player.desired_vx == 0.0 and player.desired_vy == 0.0
    return TRAP.leg if stands and length(player.vx, player.vy) < STANDING else TRAP.reach


@kernel
def too_sudden(match):
    """Return whether the ball has just been struck so hard that players only touch it if it hits them."""
    return match.was_kicked and match.kick_age < TRAP.sudden_age and ball_speed(match.ball) > TRAP.sudden_speed


@kernel
def challenge(match, i, distance):
    """Let player i, at `distance` m from the ball, try to win it from the carrier."""
    player, ball = match.players[i], match.ball
    hands = has_hands(match, i)
    if player.role == GK and player.is_sliding:
        slide_at(match, i, distance)
    elif player.role == GK and (hands or frontal(player, match.players[match.carrier]) > FEET.front):
        if distance < CLAIM.reach and ball.z < (CLAIM.below if hands else TRAP.header_from):
            claim(match, i)
    elif player.is_sliding:
        slide_into(match, i, distance)
    elif in_tackle_reach(match, i, distance) and goes_for_ball(match, i, distance):
        tackle(match, i)


@kernel
def trap(match, i):
    """Let player i bring a free ball under control, or play it first-time if a kick is requested."""
    player = match.players[i]
    asks = player.kick_ready and player.kick != 0 and ball_speed(match.ball) > TRAP.first_time_from
    stops = asks and stops_to_shoot(match, player)
    if asks and not stops:
        if player.kick == SHOT:
            slow_to_volley(player)
        kick_first_time(match, i, 1.0)
        return
    cushion(match, i)
    if stops and match.carrier == i:
        match.ball.vz = min(match.ball.vz, 0.0)
        player.brings_down, player.stance_wait = True, TRAP.settles
    if match.carrier == NOBODY and match.game_mode == NORMAL:  # the ball bounced off the player, perhaps towards a goal
        foresee(match, player.team)


@kernel
def stops_to_shoot(match, player):
    """Draw whether a player stops a ball before the requested shot: above the foot, below the head."""
    if player.kick != SHOT or not TRAP.volley_below < match.ball.z < TRAP.volley_above:
        return False
    return uniform(match) >= TRAP.volley


@kernel
def slow_to_volley(player):
    """Slow a runner down to the speed of a first-time shot."""
    share = min(TRAP.volley_run / (length(player.vx, player.vy) + 1e-9), 1.0)
    player.vx, player.vy = share * player.vx, share * player.vy


@kernel
def meets_mates_ball(player, ball, distance):
    """Return whether a ball in a player's reach no longer comes nearer, or other bodies already push the player."""
    if distance > MATES_BALL.reach or ball.z > TRAP.header_from:
        return False
    closing = (ball.x - player.x) * (ball.vx - player.vx) + (ball.y - player.y) * (ball.vy - player.vy)
    return closing >= 0.0 or player.pushed > MATES_BALL.pushed


@kernel
def kick_mates_ball(match, i):
    """Let player i, who has requested a kick, play a teammate's ball first-time.

    After a recent request, the player stops the ball first. After an older one, the player swings at the ball where it
    is, so the swing often meets only a part of the ball, or misses.
    """
    player = match.players[i]
    if STEP * (KICK_PATIENCE - player.kick_patience) < MATES_BALL.stops:
        match.players[match.carrier].touch_wait = MATES_BALL.robbed_wait
        cushion(match, i)
        return
    clean = MATES_BALL.best * uniform(match) - MATES_BALL.missed
    if clean <= 0.0:
        forget_kick(player)
        player.touch_wait = AFTER_KICK
        return
    match.players[match.carrier].touch_wait = MATES_BALL.robbed_wait
    kick_first_time(match, i, min(clean, 1.0))


@kernel
def claim(match, i):
    """Let keeper i try to win the ball at the carrier's feet; a beaten keeper lies on the ground for a while."""
    player, carrier = match.players[i], match.players[match.carrier]
    speed = length(carrier.vx, carrier.vy)
    stands, hands = speed < STANDING, has_hands(match, i)
    chance = CLAIM.standing
    if not stands:
        chance = FEET.chance
        if hands:
            chance = min(CLAIM.sure - CLAIM.hurried * speed, CLAIM.most) * (0.5 + 0.5 * player.skill)
        share = within_reach(match, i, CLAIM.swerve if hands else FEET.swerve)
        chance *= share if hands else share * (2.0 - share)
    if uniform(match) >= chance:
        player.touch_wait = CLAIM.wait if hands else FEET.wait
        player.down_wait = CLAIM.down if hands and not stands else 0.0
        if hands and not stands:
            carrier.down_wait = max(carrier.down_wait, CLAIM.bumped)
        return
    carrier.touch_wait = CLAIM.robbed_wait
    if hands and (stands or can_keep(match, i)):
        hold(match, i)
    elif hands and not slides_in(match):
        deflect(match, i)
    elif stands:
        take(match, i)  # off the feet of a waiting player
    else:
        knock_loose(match, i, match.carrier, 1.0 if hands else FEET.slides)


@kernel
def slide_at(match, i, distance):
    """Let keeper i, sliding at `distance` m from the ball, kick it away or miss it, once per slide."""
    player, ball = match.players[i], match.ball
    if player.is_slide_spent or distance > FEET.slide_reach or ball.z > TRAP.header_from:
        return
    player.is_slide_spent = True
    if uniform(match) < FEET.chance * within_reach(match, i, FEET.swerve):
        knock_loose(match, i, match.carrier, 1.0)


@kernel
def can_keep(match, i):
    """Return whether keeper i catches the carrier's ball, which must be slow and not just played."""
    player, carrier, ball = match.players[i], match.players[match.carrier], match.ball
    return is_caught_off_feet(length(ball.vx - player.vx, ball.vy - player.vy), abs(carrier.stride))


@kernel
def slides_in(match):
    """Draw whether a keeper slides at the ball of a carrier who has knocked it on."""
    carrier, ball = match.players[match.carrier], match.ball
    return apart(carrier, ball) > DEFLECT.knocked_on and uniform(match) < DEFLECT.slides


@kernel
def deflect(match, i):
    """Let keeper i knock the ball off a carrier's feet with the hands, harder at a faster run."""
    player, carrier, ball = match.players[i], match.players[match.carrier], match.ball
    before_x, before_y = ball.vx, ball.vy
    take(match, i)
    if match.carrier != i:
        return
    match.carrier = NOBODY
    player.touch_wait, player.down_wait = DEFLECT.wait, DEFLECT.down
    carrier.touch_wait = DEFLECT.robbed_wait
    share = DEFLECT.run_least + DEFLECT.run_more * uniform(match) ** DEFLECT.run_power
    run_x, run_y = share * player.vx, share * player.vy
    knock_out(match, player, run_x, run_y)
    missed = max(uniform(match) - DEFLECT.clean, 0.0) / (1.0 - DEFLECT.clean)
    ball.vx = (1.0 - missed) * ball.vx + missed * before_x
    ball.vy = (1.0 - missed) * ball.vy + missed * before_y
    ball.vz = (1.0 - missed) * PARRY.lift
    player.vx, player.vy = run_x, run_y


@kernel
def knock_loose(match, i, j, slides):
    """Let keeper i play the ball off carrier j's feet; `slides` is the probability of a slide."""
    player, carrier, ball = match.players[i], match.players[j], match.ball
    since = carrier.stride
    take(match, i)
    if match.carrier != i:
        return
    match.carrier = NOBODY
    player.touch_wait = FEET.wait
    away_x, away_y = ball.x - player.x, ball.y - player.y
    if uniform(match) >= slides:
        away_x, away_y = toward(away_x, away_y)
        ball.vx = FEET.poke_run * player.vx + FEET.poke_speed * away_x
        ball.vy = FEET.poke_run * player.vy + FEET.poke_speed * away_y
        ball.vz = FEET.poke_rise + FEET.poke_rise_spread * uniform(match)
        return
    away_x, away_y = toward(away_x + FEET.kick_run * player.vx, away_y + FEET.kick_run * player.vy)
    speed = FEET.slow + (FEET.fast - FEET.slow) * uniform(match)
    ball.vx, ball.vy, ball.vz = speed * away_x, speed * away_y, FEET.rise * speed
    player.down_wait = FEET.wait
    if since > FEET.due:
        bounce_off(match, j)
    carrier.vx, carrier.vy = FEET.blunted * carrier.vx, FEET.blunted * carrier.vy
    carrier.down_wait = FEET.stumble + FEET.stumble_spread * uniform(match)


@kernel
def bounce_off(match, j):
    """Let the ball bounce low off player j, who was hit from close by, in the direction of that player's run."""
    player, ball = match.players[j], match.ball
    ahead_x, ahead_y = toward(player.vx, player.vy)
    along = ball.vx * ahead_x + ball.vy * ahead_y
    if along >= 0.0:
        return
    ball.vx, ball.vy = ball.vx - 2.0 * along * ahead_x, ball.vy - 2.0 * along * ahead_y
    size = FEET.stopped * math.sqrt(1.0 + FEET.rise * FEET.rise)
    ball.vx, ball.vy = size * ball.vx, size * ball.vy
    ball.vz, ball.z = -FEET.drop, FEET.height
    match.last_touch = j


@kernel
def catch(match, i):
    """Let keeper i catch a free ball, or parry it if it is too fast."""
    player, ball = match.players[i], match.ball
    fast = length(ball.vx - player.vx, ball.vy - player.vy)
    if fast < CATCH.easy or is_caught(match, fast):
        hold(match, i)
    else:
        parry(match, i)


@kernel
def save(match, i):
    """Apply the outcome drawn when the shot was taken: a catch, a parry, or nothing."""
    player, ball = match.players[i], match.ball
    near = match.save_gap < CATCH.near
    match.saver = NOBODY
    if not match.save_succeeds or ball.z > CATCH.below:
        player.touch_wait, player.down_wait = CLAIM.wait, CATCH.dive_down
        return
    if has_hands(match, i) and is_caught(match, length(ball.vx, ball.vy)):
        hold(match, i)
        return
    parry(match, i)
    player.down_wait = CATCH.block_down if near else CATCH.dive_down
