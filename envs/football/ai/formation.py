"""Where everybody belongs: a block of slots that slides with the ball, and who takes which slot.

A slot is a place in the block, -1 to 1 from back to front and across, and belongs to a number in the team, wherever a
scene puts who wears it: so Google Research Football has it, whose players run to their numbers' slots from the first
step on. Mates exchange slots as the match moves them about. Places are a team's own here: u forward and v to the left,
m from the middle. Read next: `ai.support` and `ai.defence`, for why players leave their slots.
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

# Slots of the numbers 0 to 10
SLOTS = (
    (-1.0, 0.0),
    *((-0.74, 0.77), (-1.0, 0.15), (-1.0, -0.15), (-0.74, -0.77)),
    *((0.0, 0.3), (-0.12, 0.0), (0.0, -0.3)),
    *((0.36, 0.85), (1.0, 0.0), (0.36, -0.85)),
)
ROOM, ROUNDS = 0.5, 10  # by how much slots are moved apart, as far as that is reached in so many rounds

# By role, from the keeper on: in which line he plays, 0 back, 1 midfield, 2 forward, an index into tables; how much of
# an attacker he is; what is added to his block's width in attack, to its depth in defence, to how far back it stands
LINE = (0, 0, 0, 0, 1, 1, 1, 1, 1, 2)
MINDSET = (0.0, 0.0, 0.25, 0.25, 0.25, 0.5, 0.5, 0.5, 0.75, 1.0)
WIDER = (0.0, 0.052, 0.052, 0.052, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
DEEPER = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.125, 0.125)
BACK_IN_ATTACK = (0.0, 0.0, -0.1, -0.1, 0.0, 0.0, -0.1, -0.1, 0.0, 0.0)
BACK_IN_DEFENCE = (0.0, 0.0, -0.075, -0.075, 0.0, 0.0, -0.05, -0.05, 0.0, 0.0)


class Stance(NamedTuple):
    """The block of a team that attacks, or of one that defends."""

    depth: float  # half of it, as a share of `Block.depth`
    width: float  # half of it, as a share of `Block.width`
    back: float  # how far behind the ball its middle is, as a share of the pitch; 0.5 is none
    trend: float  # of its middle to where the match leans, as a share
    trend_role: float  # more of it the more of an attacker a role is
    midfield: float  # where the middle slots are stretched to, 0 back to 1 front
    close_up: float  # how far everybody closes up to the ball, as a share
    across: float  # how far everybody is drawn across to the ball, as a share


class Block(NamedTuple):
    """What both stances share."""

    depth: float = 0.45  # of half the pitch's length
    width: float = 0.95  # of half its width
    slow: float = 3.5  # s over which the ball is averaged for its place ahead,
    slow_across: float = 4.0  # and across, far from it
    haste: float = 0.7  # shares of that which are dropped near it
    haste_across: float = 0.5
    near: float = 2.0  # m to the player on the ball
    far: float = 30.0
    unsure: float = 0.6  # weight of the half in which the ball is, where it is not clear whose it is
    half: float = 0.7  # of half the length: from there on the ball is clearly in a half
    long_trend: float = 0.8  # weight of the last seconds in where the match leans
    now_trend: float = 0.2  # and of the present
    stretch: float = 0.35  # of the middle slots
    stretch_ball: float = 0.3  # weight in it of where the ball is,
    stretch_half: float = 0.8  # up to this share of half the length
    fit_depth: float = 0.95  # how far the middle stays away from the ends of the pitch,
    fit_width: float = 0.9  # and from the sides, so that the block keeps its shape


class CloseUp(NamedTuple):
    """The pull of the ball on those around it."""

    slow: float = 3.0  # s over which the ball is averaged in attack
    quick: float = 2.0  # in defence, half against the player on it
    ahead: float = 1.0  # m before the ball in attack
    behind: float = 2.0  # m behind it in defence
    inward: float = 0.9  # of its way across
    reach: float = 50.0  # m
    flat: float = 0.8  # what a distance across counts
    curve: float = 0.3  # how much of a smooth step the pull is
    peak: float = 0.15  # share of the reach where it is a little stronger,
    peak_width: float = 0.25
    peak_height: float = 0.1
    across: float = 0.6  # share of it that acts across
    least: float = 0.2  # share of it at the wrong end of the pitch


# Documented of Google Research Football; families academy and matches of `regista benchmark --suite grf`.
ATTACK = Stance(0.868, 0.948, 0.52, 0.026, 0.2, 0.828, 0.826, 0.5)
DEFENCE = Stance(0.71, 0.84, 0.54, 0.182, -0.2, 0.776, 0.938, 0.2)
BLOCK, CLOSE_UP = Block(), CloseUp()
LOOK_AHEAD = 0.5  # s by which runs are led where slots are exchanged
EXCHANGED_EVERY = 4  # steps
EXCHANGE = 0.95  # two mates exchange slots when that shortens their ways to less than this share


@cache
def formation_slots(count: int) -> np.ndarray:
    """Return the slots [count, 2] of the first numbers of a team, moved apart from each other; the keeper's stays."""
    slots = np.array(SLOTS[:count]).reshape(-1, 2)
    for _ in range(ROUNDS):
        between = slots[1:, None] - slots[None, 1:]
        distance = np.linalg.norm(between, axis=-1, keepdims=True)
        lack = np.where(distance < ROOM, ROOM - distance, 0.0)
        slots[1:] += (0.5 * lack * between / np.maximum(distance, 1e-9)).sum(axis=1)
        slots = np.clip(slots, -1.0, 1.0)
    slots.flags.writeable = False  # it is handed out again
    return slots


@kernel
def smooth(share, strength):
    """Return a share in [0, 1], bent by so much into a smooth step."""
    if share in (0.0, 1.0):
        return share  # often, and a sine is dear
    return strength * (0.5 + 0.5 * math.sin(math.pi * (share - 0.5))) + (1.0 - strength) * share


@kernel
def between(value, low, high):
    """Return where a value lies between two others: 0 to 1."""
    return min(max((value - low) / (high - low), 0.0), 1.0)


@kernel
def blend(attack, defence, attacking):
    """Return a number of the stance between the two, `attacking` 0 to 1."""
    return attack * attacking + defence * (1.0 - attacking)


@kernel
def slot_position_for(match, player, number, on_ball):
    """Return the place in m of the slot of player number `number` of his team, for a player who may be another.

    `on_ball` is the player who has the ball or will be first at it. The stages: how far the team attacks, its block,
    the slot in it, and how far the ball draws him out of it.
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
    """Return the place in m of player i's own slot, which is known in the steps in which slots are exchanged."""
    player = match.players[i]
    if match.step % EXCHANGED_EVERY == 0:
        return player.slot_place_x, player.slot_place_y
    return slot_position_for(match, player, i, on_ball)


@kernel
def how_far_attacking(match, team, ball_u):
    """Return how far a team attacks, 0 to 1: by its hold on the ball, or unless clear by its half."""
    held = between(match.hold[team] - 0.5, 0.3, 0.7)
    if held in (0.0, 1.0):
        return held
    unsure = BLOCK.unsure * (1.0 - abs(2.0 * held - 1.0))
    return held * (1.0 - unsure) + unsure * between(ball_u / HALF_LENGTH, -BLOCK.half, BLOCK.half)


@kernel
def block(match, team, role, attacking, ball_u, ball_v):
    """Return a team's block for a role: back and front, right and left edge, in m."""
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
    """Return a slot's depth: the middle ones are stretched towards where the team needs them."""
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
    """Take down where the ball has been on average, for all who close up to it in this step."""
    for axis in range(2):
        match.slow_ball[axis] = mean_ball(match, CLOSE_UP.slow, axis)
        match.quick_ball[axis] = mean_ball(match, CLOSE_UP.quick, axis)


@kernel
def focus(match, first, team, attacking, back):
    """Return the place to which everybody near closes up: before the ball in attack, behind it in defence."""
    ahead, slow, quick = forward(team), match.slow_ball, match.quick_ball
    u = blend(ahead * slow[0], 0.5 * (ahead * quick[0] + ahead * first.x), attacking)
    v = CLOSE_UP.inward * blend(ahead * slow[1], 0.5 * (ahead * quick[1] + ahead * first.y), attacking)
    return blend(min(u + CLOSE_UP.ahead, HALF_LENGTH), max(u - CLOSE_UP.behind, back, -HALF_LENGTH), attacking), v


@kernel
def close_up(du, dv):
    """Return the share of the way to the focus, so far away, that a slot is drawn to it at most."""
    far = length(du, CLOSE_UP.flat * dv) / CLOSE_UP.reach
    if far >= 1.0:
        return 0.0
    peak = CLOSE_UP.peak_height * (1.0 - min(abs(far - CLOSE_UP.peak) / CLOSE_UP.peak_width, 1.0))
    return min(smooth(1.0 - far, CLOSE_UP.curve) + peak, 1.0)


@kernel
def close_up_strength(attacking, ball_u):
    """Return how far everybody closes up: in attack the more the further forward the ball, in defence the further
    back.
    """
    side = 0.3 + 0.7 * between(ball_u / HALF_LENGTH, -BLOCK.half, BLOCK.half)
    attack = side**0.8 if attacking > 0.0 else 0.0  # powers are dear, and mostly one of them counts
    defence = (1.0 - side) ** 0.6 if attacking < 1.0 else 0.0
    share = blend(attack, defence, attacking)
    share = CLOSE_UP.least + (1.0 - CLOSE_UP.least) * share
    return share * blend(ATTACK.close_up, DEFENCE.close_up, attacking)


@kernel
def exchange_slots(match, on_ball):
    """Let every two mates exchange their slots if that shortens their ways (their squares, so that no way is long)."""
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
    """Return how many players of `team` are on the pitch and no keepers."""
    count = 0
    for i in range(match.num_players):
        player = match.players[i]
        count += player.team == team and player.role != GK and not player.has_left
    return count


@kernel
def exchange(match, a, b, x, y, of_two):
    """Exchange two mates' slots if that shortens their ways; a will be at (x, y).

    Of a team of two either way must become shorter than both are now: the original looks for exchanges of short ways
    first, and of two mates it tries no others.
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
