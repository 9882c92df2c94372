"""Where everybody belongs: a block of slots that slides with the ball, and who takes which slot.

A slot is a place in the block, -1 to 1 from back to front and across. It comes from the line-up at kick-off and from
the role; players exchange slots as the match moves them about. The sizes of the block and how it follows the ball are
fitted to whole matches of Google Research Football. Read next: `ai.marking`, for who leaves his slot.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from envs.football.constants import AM, CB, CF, CM, DM, GK, HALF_LENGTH, HALF_WIDTH, LB, LM, RB, RM, STEP
from envs.football.physics.pitch import forward
from envs.football.physics.vectors import squared_apart
from scenic_lite.kernels.jit import kernel


class Block(NamedTuple):
    """The block of slots, and how it follows the ball."""

    memory: float = 2.5  # s over which the ball is averaged
    follow_slow: float = 0.36  # share of the averaged ball's x at which the block stands,
    follow_fast: float = 0.22  # and of the ball's
    set_back: float = 1.2  # m towards the own goal
    follow_across: float = 0.4  # share of the averaged ball's y
    depth: float = 11.0  # m, half of the block
    width: float = 24.0  # m, half of it
    focus: float = 0.4  # in defence slots close up to the ball by this share,
    focus_range: float = 30.0  # fading out over m
    edge: float = 3.0  # m from the lines
    exchange: float = 0.9  # two players exchange slots when that shortens their ways to less than this share


# Fitted to whole matches of Google Research Football: `regista benchmark --suite grf`, family matches.
BLOCK = Block()

# Slots
ROLE_DEPTH = {GK: -1.0, CB: -1.0, LB: -0.8, RB: -0.8, DM: -0.4, CM: 0.0, LM: 0.4, RM: 0.4, AM: 0.5, CF: 1.0}
LINED_UP = 4.0  # m; a line-up that is less deep tells nothing, and the roles decide
LINE_UP_SHARE = 0.7  # of the line-up in a slot's depth, the rest is the role
LINE_UP_WIDTH = 18.0  # m from the middle of the pitch that are as wide as the block


def formation_slots(x: np.ndarray, y: np.ndarray, roles: np.ndarray) -> np.ndarray:
    """Return the slots [N, 2, P] of a team whose players stand at `x` (forward) and `y` [N, P] m, with `roles` [P]."""
    field = roles != GK
    depth = np.broadcast_to([ROLE_DEPTH[role] for role in roles], x.shape).astype(float)
    if field.any():
        back, front = x[:, field].min(axis=1, keepdims=True), x[:, field].max(axis=1, keepdims=True)
        known = front - back > LINED_UP
        place = np.clip(2.0 * (x - back) / np.where(known, front - back, 1.0) - 1.0, -1.0, 1.0)
        depth = np.where(known & field, LINE_UP_SHARE * place + (1.0 - LINE_UP_SHARE) * depth, depth)
    return np.stack([depth, np.clip(y / LINE_UP_WIDTH, -1.0, 1.0)], axis=1)


@kernel
def remember_ball(match):
    """Move the averaged ball on."""
    match.mean_ball_x += (match.ball.x - match.mean_ball_x) * (STEP / BLOCK.memory)
    match.mean_ball_y += (match.ball.y - match.mean_ball_y) * (STEP / BLOCK.memory)


@kernel
def block_x(match, team):
    """Return x of the middle of a team's block, in m."""
    return BLOCK.follow_slow * match.mean_ball_x + BLOCK.follow_fast * match.ball.x - forward(team) * BLOCK.set_back


@kernel
def formation_place(match, player):
    """Return the place in m of a player's slot."""
    x = block_x(match, player.team) + forward(player.team) * BLOCK.depth * player.slot_x
    y = BLOCK.follow_across * match.mean_ball_y + BLOCK.width * player.slot_y
    return on_pitch(x, y)


@kernel
def on_pitch(x, y):
    """Return the nearest place that is not close to a line."""
    limit_x, limit_y = HALF_LENGTH - BLOCK.edge, HALF_WIDTH - BLOCK.edge
    return min(max(x, -limit_x), limit_x), min(max(y, -limit_y), limit_y)


@kernel
def exchange_slots(match):
    """Let every two mates exchange their slots if that shortens their ways (their squares, so that no way is long)."""
    for i in range(1, match.num_players):
        a = match.players[i]
        if a.role == GK or a.has_left:
            continue
        for j in range(i):
            b = match.players[j]
            if b.team == a.team and b.role != GK and not b.has_left:
                exchange(match, a, b)


@kernel
def exchange(match, a, b):
    """Exchange two mates' slots if that shortens their ways."""
    ax, ay = formation_place(match, a)
    bx, by = formation_place(match, b)
    stay = squared_apart(a, ax, ay) + squared_apart(b, bx, by)
    change = squared_apart(a, bx, by) + squared_apart(b, ax, ay)
    if change < BLOCK.exchange * stay:
        a.slot_x, b.slot_x = b.slot_x, a.slot_x
        a.slot_y, b.slot_y = b.slot_y, a.slot_y
