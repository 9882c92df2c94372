"""The formation: a block of slots that moves with the ball, and which player takes which slot.

A slot is a position in the block, -1 to 1 from back to front and across. It belongs to a shirt number and does not
depend on the player's position in a scene: in Google Research Football, players run to the slots of their numbers from
the first step on. Teammates exchange slots during the match. Positions in this module are in the team's frame: u
forward and v to the left, in m from the middle. Read next: `ai.support` and `ai.defence`, which move players off their
slots.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from regista.envs.football.ai.balance import mean_ball, possession_trend
from regista.envs.football.constants import GK, HALF_LENGTH, HALF_WIDTH, LEFT, RIGHT
from regista.envs.football.physics.pitch import forward
from regista.envs.football.physics.vectors import length
from regista.kernels.jit import kernel

# Slots of the shirt numbers 0 to 10, from the keeper on
SLOTS = (
    (-1.0, 0.0),
    *((-0.74, 0.77), (-1.0, 0.15), (-1.0, -0.15), (-0.74, -0.77)),
    *((0.0, 0.3), (-0.12, 0.0), (0.0, -0.3)),
    *((0.36, 0.85), (1.0, 0.0), (0.36, -0.85)),
)
ROOM, ROUNDS = 0.5, 10  # minimum distance of slots, and rounds of moving them apart

# By role, from the keeper on: the line (0 back, 1 midfield, 2 forward), an index into tables; how attacking a role is;
# additions to the width of its block in attack, to the depth in defense, to the distance behind the ball
LINE = (0, 0, 0, 0, 1, 1, 1, 1, 1, 2)
MINDSET = (0.0, 0.0, 0.25, 0.25, 0.25, 0.5, 0.5, 0.5, 0.75, 1.0)
WIDER = (0.0, 0.052, 0.052, 0.052, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
DEEPER = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.125, 0.125)
BACK_IN_ATTACK = (0.0, 0.0, -0.1, -0.1, 0.0, 0.0, -0.1, -0.1, 0.0, 0.0)
BACK_IN_DEFENCE = (0.0, 0.0, -0.075, -0.075, 0.0, 0.0, -0.05, -0.05, 0.0, 0.0)


class Stance(NamedTuple):
    """The shape of a team's block in attack or in defense."""

    depth: float  # half of the block's depth, as a share of `Block.depth`
    width: float  # half of the block's width, as a share of `Block.width`
    back: float  # distance of the block's middle behind the ball, as a share of the pitch; 0.5 is level
    trend: float  # shift of the block's middle by the possession trend, as a share
    trend_role: float  # added to the shift, per unit of how attacking a role is
    midfield: float  # depth towards which the middle slots are stretched, 0 back to 1 front
    close_up: float  # share by which players close up to the ball
    across: float  # share by which players move across to the ball


class Block(NamedTuple):
    """The parameters of the block that attack and defense share."""

    depth: float = 0.45  # share of half the pitch's length
    width: float = 0.95  # share of half the pitch's width
    slow: float = 3.5  # s over which the ball's x is averaged, for players far from it
    slow_across: float = 4.0  # s over which its y is averaged
    haste: float = 0.7  # share of these times that is dropped near the ball
    haste_across: float = 0.5
    near: float = 2.0  # m to the player on the ball, at which a player is near
    far: float = 30.0
    unsure: float = 0.6  # weight of the half that the ball is in, while possession is unclear
    half: float = 0.7  # share of half the length, beyond which the ball is clearly in a half
    long_trend: float = 0.8  # weight of the possession trend
    now_trend: float = 0.2  # weight of present possession
    stretch: float = 0.35  # strength of stretching the middle slots
    stretch_ball: float = 0.3  # weight of the ball's position in this stretching,
    stretch_half: float = 0.8  # up to this share of half the length
    fit_depth: float = 0.95  # share by which the middle stays away from the ends of the pitch
    fit_width: float = 0.9  # the same for the sides; both keep the shape of the block


class CloseUp(NamedTuple):
    """The pull of the ball on nearby players."""

    slow: float = 3.0  # s over which the ball is averaged in attack
    quick: float = 2.0  # s in defense; averaged with the position of the player on the ball
    ahead: float = 1.0  # m in front of the ball in attack
    behind: float = 2.0  # m behind the ball in defense
    inward: float = 0.9  # share of the ball's lateral position
    reach: float = 50.0  # m, range of the pull
    flat: float = 0.8  # weight of a lateral distance
    curve: float = 0.3  # blend between a linear and a smooth step
    peak: float = 0.15  # share of the reach at which the pull is a little stronger
    peak_width: float = 0.25
    peak_height: float = 0.1
    across: float = 0.6  # share of the pull that acts across
    least: float = 0.2  # share of the pull at the far end of the pitch


# Documented by Google Research Football; families academy and matches of `lab.benchmarks --suite grf`.
ATTACK = Stance(0.868, 0.948, 0.52, 0.026, 0.2, 0.828, 0.826, 0.5)
DEFENCE = Stance(0.71, 0.84, 0.54, 0.182, -0.2, 0.776, 0.938, 0.2)
BLOCK, CLOSE_UP = Block(), CloseUp()
LOOK_AHEAD = 0.5  # s by which runs are extrapolated when slots are exchanged
EXCHANGED_EVERY = 4  # steps
EXCHANGE = 0.95  # two teammates exchange slots if this reduces their ways to less than this share


@cache
def formation_slots(count: int) -> np.ndarray:
    """Return the slots [count, 2] of the first shirt numbers; all slots but the keeper's are moved apart."""
    slots = np.array(SLOTS[:count]).reshape(-1, 2)
    for _ in range(ROUNDS):
        between = slots[1:, None] - slots[None, 1:]
        distance = np.linalg.norm(between, axis=-1, keepdims=True)
        lack = np.where(distance < ROOM, ROOM - distance, 0.0)
        slots[1:] += (0.5 * lack * between / np.maximum(distance, 1e-9)).sum(axis=1)
        slots = np.clip(slots, -1.0, 1.0)
    slots.flags.writeable = False  # the cached array is shared
    return slots


@kernel
def smooth(share, strength):
    """Return a share in [0, 1], blended with a smooth step by `strength`."""
    if share in (0.0, 1.0):
        return share  # a frequent case, and a sine is slow
    return strength * (0.5 + 0.5 * math.sin(math.pi * (share - 0.5))) + (1.0 - strength) * share


@kernel
def between(value, low, high):
    """Return the relative position of a value between two others, 0 to 1."""
    return min(max((value - low) / (high - low), 0.0), 1.0)


@kernel
def blend(attack, defence, attacking):
    """Interpolate between attack and defense, `attacking` 0 to 1."""
    return attack * attacking + defence * (1.0 - attacking)


@kernel
def slot_position_for(match, player, number, on_ball):
    """Return the position in m of the slot of shirt number `number`, for a player with the same or another number.

    `on_ball` is the player who has the ball or will be first at it. The stages are: how far the team attacks, its
    block, the slot in the block, and the pull of the ball on the player.
    """
    ahead = forward(player.team)
    owner, first = match.players[number], match.players[on_ball]
    distance = length(first.x - player.x, first.y - player.y)
    haste = 1.0 - between(distance, BLOCK.near, BLOCK.far)
    ball_u = ahead * mean_ball(match, BLOCK.slow * (1.0 - BLOCK.haste * haste), 0)
    ball_v = ahead * mean_ball(match, BLOCK.slow_across * (1.0 - BLOCK.haste_across * haste), 1)
    attacking = how_far_attacking(match, player.team, ball_u)
    back, front, low, high = block(match, player.team, owner.role, attacking, ball_u, ball_v)
    u = back + 0.5 * (1.0 + stretched(owner.slot_x, attacking, ball_u)) * (front - back)
    v = low + 0.5 * (1.0 + owner.slot_y) * (high - low)
    pure_v = v
    draw = (1.0 - min(abs(ball_v - v) / (high - low), 1.0)) * (0.2 + 0.8 * abs(ball_v) / HALF_WIDTH)
    v += draw * blend(ATTACK.across, DEFENCE.across, attacking) * (ball_v - v)
    focus_u, focus_v = focus(match, first, player.team, attacking, back)
    draw = close_up(focus_u - u, focus_v - pure_v)
    if draw > 0.0:
        draw *= close_up_strength(attacking, ball_u)
        u += draw * (focus_u - u)
        v += draw * CLOSE_UP.across * (focus_v - v)
    u, v = min(max(u, -HALF_LENGTH), HALF_LENGTH), min(max(v, -HALF_WIDTH), HALF_WIDTH)
    return ahead * u, ahead * v


@kernel
def slot_position(match, i, on_ball):
    """Return the position in m of player i's own slot, and store it in steps in which slots are exchanged."""
    player = match.players[i]
    if match.step % EXCHANGED_EVERY == 0:
        return player.slot_place_x, player.slot_place_y
    return slot_position_for(match, player, i, on_ball)


@kernel
def how_far_attacking(match, team, ball_u):
    """Return how far a team attacks, 0 to 1: by possession, or by the ball's half of the pitch if possession is
    unclear.
    """
    held = between(match.hold[team] - 0.5, 0.3, 0.7)
    if held in (0.0, 1.0):
        return held
    unsure = BLOCK.unsure * (1.0 - abs(2.0 * held - 1.0))
    return held * (1.0 - unsure) + unsure * between(ball_u / HALF_LENGTH, -BLOCK.half, BLOCK.half)


@kernel
def block(match, team, role, attacking, ball_u, ball_v):
    """Return a team's block for a role in m: its back, front, right and left edges."""
    depth = BLOCK.depth * blend(ATTACK.depth, DEFENCE.depth + DEEPER[role], attacking)
    width = BLOCK.width * blend(ATTACK.width + WIDER[role], DEFENCE.width, attacking)
    back = blend(ATTACK.back + BACK_IN_ATTACK[role], DEFENCE.back + BACK_IN_DEFENCE[role], attacking)
    attacker = MINDSET[role] - 0.5
    trend = blend(
        min(max(ATTACK.trend + ATTACK.trend_role * attacker, 0.0), 1.0),
        min(max(DEFENCE.trend + DEFENCE.trend_role * attacker, 0.0), 1.0),
        attacking,
    )
    side = BLOCK.now_trend * (2.0 * attacking - 1.0) + BLOCK.long_trend * possession_trend(match, team)
    middle = ball_u + trend * (HALF_LENGTH * side - ball_u) - HALF_LENGTH * (2.0 * back - 1.0)
    middle = min(max(middle, -HALF_LENGTH), HALF_LENGTH) * (1.0 - BLOCK.fit_depth * depth)
    across = min(max(ball_v, -HALF_WIDTH), HALF_WIDTH) * (1.0 - BLOCK.fit_width * width)
    rear = max(middle - depth * HALF_LENGTH, min(match.trap[team], HALF_LENGTH))
    return rear, middle + depth * HALF_LENGTH, across - width * HALF_WIDTH, across + width * HALF_WIDTH


@kernel
def stretched(slot_x, attacking, ball_u):
    """Return a slot's depth: middle slots are stretched towards the back or the front, as the team needs them."""
    near_middle = 1.0 - abs(1.2 * slot_x)
    if near_middle <= 0.0:
        return slot_x
    ball = between(ball_u / HALF_LENGTH, -BLOCK.stretch_half, BLOCK.stretch_half)
    middle = blend(ATTACK.midfield, DEFENCE.midfield, attacking)
    middle += BLOCK.stretch_ball * (ball - middle)
    share = BLOCK.stretch * smooth(near_middle, 1.0)
    return slot_x + share * (2.0 * middle - 1.0 - slot_x)


@kernel
def follow_ball(match):
    """Store averages of the ball's position for this step, shared by all players who close up to the ball."""
    for axis in range(2):
        match.slow_ball[axis] = mean_ball(match, CLOSE_UP.slow, axis)
        match.quick_ball[axis] = mean_ball(match, CLOSE_UP.quick, axis)


@kernel
def focus(match, first, team, attacking, back):
    """Return the point to which nearby players close up: in front of the ball in attack, behind it in defense."""
    ahead, slow, quick = forward(team), match.slow_ball, match.quick_ball
    u = blend(ahead * slow[0], 0.5 * (ahead * quick[0] + ahead * first.x), attacking)
    v = CLOSE_UP.inward * blend(ahead * slow[1], 0.5 * (ahead * quick[1] + ahead * first.y), attacking)
    return blend(min(u + CLOSE_UP.ahead, HALF_LENGTH), max(u - CLOSE_UP.behind, back, -HALF_LENGTH), attacking), v


@kernel
def close_up(du, dv):
    """Return the maximum share of the way (du, dv) to the focus by which a slot moves towards it."""
    far = length(du, CLOSE_UP.flat * dv) / CLOSE_UP.reach
    if far >= 1.0:
        return 0.0
    peak = CLOSE_UP.peak_height * (1.0 - min(abs(far - CLOSE_UP.peak) / CLOSE_UP.peak_width, 1.0))
    return min(smooth(1.0 - far, CLOSE_UP.curve) + peak, 1.0)


@kernel
def close_up_strength(attacking, ball_u):
    """Return how far players close up: more if the ball is further forward in attack, or further back in defense."""
    side = 0.3 + 0.7 * between(ball_u / HALF_LENGTH, -BLOCK.half, BLOCK.half)
    attack = side**0.8 if attacking > 0.0 else 0.0  # avoids slow powers; usually only one of them counts
    defence = (1.0 - side) ** 0.6 if attacking < 1.0 else 0.0
    share = blend(attack, defence, attacking)
    share = CLOSE_UP.least + (1.0 - CLOSE_UP.least) * share
    return share * blend(ATTACK.close_up, DEFENCE.close_up, attacking)


@kernel
def exchange_slots(match, on_ball):
    """Let each pair of teammates exchange slots if that shortens their squared distances to the slots."""
    for i in range(match.num_players):
        player = match.players[i]
        if player.role != GK:
            player.slot_place_x, player.slot_place_y = slot_position_for(match, player, i, on_ball)
    of_two_left, of_two_right = outfield(match, LEFT) == 2, outfield(match, RIGHT) == 2
    for i in range(1, match.num_players):
        a = match.players[i]
        if a.role == GK or a.has_left:
            continue
        of_two = of_two_left if a.team == LEFT else of_two_right
        x, y = a.x + LOOK_AHEAD * a.vx, a.y + LOOK_AHEAD * a.vy
        for j in range(i):
            b = match.players[j]
            if b.team == a.team and b.role != GK and not b.has_left:
                exchange(match, a, b, x, y, of_two)


@kernel
def outfield(match, team):
    """Return how many players of `team`, without keepers, are on the pitch."""
    count = 0
    for i in range(match.num_players):
        player = match.players[i]
        count += player.team == team and player.role != GK and not player.has_left
    return count


@kernel
def exchange(match, a, b, x, y, of_two):
    """Exchange two teammates' slots if that shortens their ways; a will be at (x, y).

    In a team of two, both new ways must be shorter than both old ones: GRF tries exchanges of short ways first, and for
    two players only these.
    """
    own_slot, other_slot = match.players[a.post], match.players[b.post]
    other_x, other_y = b.x + LOOK_AHEAD * b.vx, b.y + LOOK_AHEAD * b.vy
    stay, other_stay = squared_way(x, y, own_slot), squared_way(other_x, other_y, other_slot)
    change, other_change = squared_way(x, y, other_slot), squared_way(other_x, other_y, own_slot)
    if of_two:
        shorter = max(change, other_change) < min(stay, other_stay)
    else:
        shorter = change + other_change < EXCHANGE * (stay + other_stay)
    if shorter:
        a.post, b.post = b.post, a.post


@kernel
def squared_way(x, y, owner):
    """Return the square of the distance in m from (x, y) to the slot of `owner`."""
    dx, dy = x - owner.slot_place_x, y - owner.slot_place_y
    return dx * dx + dy * dy
