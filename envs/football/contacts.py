"""Meetings of players with a ball that is not theirs: traps, tackles, claims by hand, saves and blocks.

Read next: `rules`.
"""

from __future__ import annotations

import math

from envs.football.constants import GK, NOBODY, NORMAL, STEP
from envs.football.fouls import report_foul
from envs.football.saves import in_own_box
from envs.football.touch import BLOCK_KEEP, deflect, hold, parry, take
from envs.football.vectors import length, toward
from scenic_lite.jit import kernel
from scenic_lite.stream import uniform

# Traps
TRAP_REACH, TRAP_BELOW = 0.75, 1.9  # m
EASY_SPEED, HARD_SPEED = 20.0, 36.0  # m/s relative: always trapped, never trapped
HEADER_FROM, HEADER_CHANCE = 0.9, 0.5  # m; above it a trap succeeds this often

# Tackles
TACKLE_REACH, SLIDE_REACH = 0.85, 1.15  # m from the body to the ball
TACKLE_CHANCE, TACKLE_BEHIND, SLIDE_CHANCE = 0.7, 0.4, 0.85
SWERVE = 10.0  # m/s across the tackler's reach at which the ball cannot be won
TACKLE_WAIT, BEATEN_DOWN, ROBBED_WAIT = 0.6, 0.3, 0.7  # s
SIDE_COSINE = 0.7  # less than this off straight ahead or straight behind is from the side
FOUL_SIDE, FOUL_BEHIND, FOUL_SPEED = 0.9, 0.75, 2.0  # chances; m/s of a carrier who runs
SIDE_SEVERITY = 1.5  # of a slide that misses the ball, from the side: a yellow card

# Keepers
CLAIM_REACH, CLAIM_BELOW = 0.95, 2.2  # m
CLAIM_CHANCE, CLAIM_WAIT, CLAIM_DOWN = 0.72, 1.2, 1.0  # chance against a carrier; s when beaten
SAVE_REACH = 1.2  # m
CATCH_NEAR, CATCH_CHANCE, CATCH_DIVING = 0.6, 0.7, 0.08  # m; chances that a save is a catch
BLOCK_DOWN, DIVE_DOWN = 0.1, 0.7  # s on the ground after a block on the spot, after a dive


@kernel
def reachable(match):
    """Return a bit for every player who may meet the ball within a step."""
    ball = match.ball
    reach = 1.4 + STEP * (8.0 + math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy))
    bits = 0
    for i in range(match.num_players):
        player = match.players[i]
        dx, dy = ball.x - player.x, ball.y - player.y
        if dx * dx + dy * dy < reach * reach:
            bits |= 1 << i
    return bits


@kernel
def meet_ball(match, bits):
    """Let every player named in `bits` try for the ball in this frame; who goes first alternates between steps."""
    for k in range(match.num_players):
        i = k if match.step % 2 == 0 else match.num_players - 1 - k
        if match.game_mode != NORMAL:
            return
        if bits >> i & 1 == 0 or match.holder != NOBODY or match.carrier == i:
            continue
        player = match.players[i]
        if player.touch_wait > 0.0 or (player.down > 0.0 and not player.sliding):
            continue
        dx, dy = match.ball.x - player.x, match.ball.y - player.y
        squared = dx * dx + dy * dy
        if squared < SAVE_REACH * SAVE_REACH:
            meet(match, i, math.sqrt(squared))


@kernel
def meet(match, i, distance):
    """Let player i, this far from the ball, do what suits: save, claim, tackle, or trap."""
    player, ball = match.players[i], match.ball
    hands = player.role == GK and in_own_box(player)
    if match.saver == i:
        if match.save_wait < STEP:
            save(match, i)
    elif match.carrier != NOBODY:
        if match.players[match.carrier].team == player.team:
            return
        if player.role == GK and distance < CLAIM_REACH and ball.z < (CLAIM_BELOW if hands else HEADER_FROM):
            claim(match, i)
        elif distance < (SLIDE_REACH if player.sliding else TACKLE_REACH) and ball.z < HEADER_FROM:
            tackle(match, i)
    elif hands and distance < CLAIM_REACH and ball.z < CLAIM_BELOW:
        catch(match, i)
    elif distance < TRAP_REACH and ball.z < TRAP_BELOW:
        trap(match, i)


@kernel
def trap(match, i):
    """Let player i bring a free ball under control, or fail to if it comes too hard."""
    player, ball = match.players[i], match.ball
    fast = length(ball.vx - player.vx, ball.vy - player.vy)
    chance = min(max((HARD_SPEED - fast) / (HARD_SPEED - EASY_SPEED), 0.0), 1.0)
    if ball.z > HEADER_FROM:
        chance *= HEADER_CHANCE
    if uniform(match) < chance:
        take(match, i)
        return
    deflect(match, i, BLOCK_KEEP)


@kernel
def tackle(match, i):
    """Let player i try to take the ball off the carrier's feet."""
    player, carrier = match.players[i], match.players[match.carrier]
    if player.sliding and is_foul(match, i):
        report_foul(match, i, match.carrier, SIDE_SEVERITY, True)
        player.touch_wait, carrier.touch_wait = TACKLE_WAIT, ROBBED_WAIT
        return
    behind = (player.x - carrier.x) * carrier.facing_x + (player.y - carrier.y) * carrier.facing_y < -0.2
    chance = (SLIDE_CHANCE if player.sliding else TACKLE_CHANCE) * (0.4 + 0.6 * player.skill) * within_reach(match, i)
    if behind:
        chance *= TACKLE_BEHIND
    if uniform(match) < chance:
        carrier.touch_wait = ROBBED_WAIT
        take(match, i)
        return
    player.touch_wait = TACKLE_WAIT
    player.down = max(player.down, BEATEN_DOWN)


@kernel
def is_foul(match, i):
    """Draw whether player i's slide fells the carrier: from the side mostly, from behind if he runs, never frontal."""
    player, carrier = match.players[i], match.players[match.carrier]
    ux, uy = toward(player.x - carrier.x, player.y - carrier.y)
    front = ux * carrier.facing_x + uy * carrier.facing_y
    if abs(front) < SIDE_COSINE:
        return uniform(match) < FOUL_SIDE
    runs = length(carrier.vx, carrier.vy) > FOUL_SPEED
    return front < 0.0 and runs and uniform(match) < FOUL_BEHIND


@kernel
def within_reach(match, i):
    """Share of player i's chance to win the ball that is left by a carrier who swerves across his reach."""
    player, ball, carrier = match.players[i], match.ball, match.players[match.carrier]
    dx, dy = ball.x - player.x, ball.y - player.y
    swerve = abs(carrier.vx * dy - carrier.vy * dx) / (length(dx, dy) + 1e-9)
    return max(1.0 - swerve / SWERVE, 0.0)


@kernel
def claim(match, i):
    """Let keeper i try to take the ball off the carrier's feet; beaten, he lies on the ground for a while."""
    player, carrier = match.players[i], match.players[match.carrier]
    chance = CLAIM_CHANCE * (0.5 + 0.5 * player.skill) * within_reach(match, i)
    if uniform(match) < chance:
        carrier.touch_wait = ROBBED_WAIT
        if in_own_box(player):
            hold(match, i)
        else:
            take(match, i)
        return
    player.touch_wait, player.down = CLAIM_WAIT, CLAIM_DOWN


@kernel
def catch(match, i):
    """Let keeper i take a free ball with his hands, or parry it if it comes too hard."""
    player, ball = match.players[i], match.ball
    fast = length(ball.vx - player.vx, ball.vy - player.vy)
    if uniform(match) < min(max((HARD_SPEED - fast) / (HARD_SPEED - EASY_SPEED), 0.0), 1.0):
        hold(match, i)
    else:
        parry(match, i)


@kernel
def save(match, i):
    """Carry out what was drawn when the shot was taken: a catch, a parry, or nothing."""
    player, ball = match.players[i], match.ball
    succeeds = match.save_succeeds and ball.z < CLAIM_BELOW + 0.5
    match.saver = NOBODY
    if not succeeds:
        player.touch_wait, player.down = CLAIM_WAIT, DIVE_DOWN
        return
    if uniform(match) < (CATCH_CHANCE if match.save_gap < CATCH_NEAR else CATCH_DIVING):
        hold(match, i)
    else:
        parry(match, i)
        player.down = BLOCK_DOWN if match.save_gap < CATCH_NEAR else DIVE_DOWN
