"""Bodies on the pitch: they move, cannot overlap, and stop at the edge of the grass.

Read next: `frames`, which calls this in every frame.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import APRON, BODY_RADIUS, DT, HALF_LENGTH, HALF_WIDTH, LEFT, STEP
from regista.envs.football.physics.vectors import length
from regista.kernels.jit import kernel


class Push(NamedTuple):
    """Which of two colliding bodies gives way, and the loss of speed, as documented by Google Research Football."""

    back: float = 0.8  # a player with the back to the other gives way less by this
    speed: float = 0.2  # the faster player gives way more by this, in full at a difference of
    speed_range: float = 8.0  # m/s
    ball: float = 0.4  # the carrier gives way less by this; the sum of all three is clipped to [-1, 1]
    least: float = 0.25  # minimum share of the displacement for a player who gives way
    most: float = 0.1  # m, maximum displacement that affects the velocity afterwards
    kept: float = 0.6  # share of this effect that is left a step later: 0.95 a frame
    along: float = 1.87  # m between teammates, within which they adopt each other's movement
    drag: float = 0.24  # maximum share of the difference of velocities
    uneven: float = 0.45  # added to one half of this share for the player who gives way


PUSH = Push()
# Measured in Google Research Football for players who overlap when play begins: `lab.benchmarks --suite grf`,
# family academy.
SAME_PLACE = 0.03  # m; bodies closer than this overlap fully and stumble apart
STUMBLE = 0.3  # s, for which one body steps to the right, and the other on the spot
STUMBLE_SPEED = 3.9  # m/s
STEPS_ASIDE = 0.22  # m, immediate displacement of each body
BODIES_NEAR = 2.6  # m; pairs further apart than this cannot meet within a step


@kernel
def advance_players(match, who, frames):
    """Move the players whose bits are in `who` by `frames` frames of 10 ms; return 0, the number of frames left."""
    for i in range(match.num_players):
        if who >> i & 1 == 1:
            player = match.players[i]
            x, y, dx, dy = player.x, player.y, player.vx * DT, player.vy * DT
            for _ in range(frames):
                x += dx
                y += dy
            player.x, player.y = x, y
    return 0


@kernel
def keep_on_pitch(player):
    """Stop a player at the edge of the grass, a little beyond the lines."""
    if player.has_left:
        return
    if abs(player.x) > HALF_LENGTH + APRON:
        player.x = math.copysign(HALF_LENGTH + APRON, player.x)
        player.vx = 0.0
    if abs(player.y) > HALF_WIDTH + APRON:
        player.y = math.copysign(HALF_WIDTH + APRON, player.y)
        player.vy = 0.0


@kernel
def crowded(match):
    """Find the pairs of players who could meet within this step; return the bits of all players in any pair."""
    crowd = 0
    for i in range(1, match.num_players):
        a = match.players[i]
        x, y, near = a.x, a.y, 0
        for j in range(i):
            b = match.players[j]
            near |= ((abs(x - b.x) < BODIES_NEAR) & (abs(y - b.y) < BODIES_NEAR)) << j  # branch-free: half as long
        a.near_bits = near
        if near != 0:
            crowd |= near | 1 << i
    return crowd


@kernel
def part_bodies(match, crowd):
    """Push overlapping players in the pairs of a `crowd` apart; a beaten player does not obstruct opponents."""
    for i in range(1, match.num_players):
        if crowd >> i & 1 == 0:
            continue
        a = match.players[i]
        near, j = a.near_bits, -1
        while near != 0:
            here, j = near & 1, j + 1
            near >>= 1
            if here == 0:
                continue
            b = match.players[j]
            dx, dy = a.x - b.x, a.y - b.y
            squared = dx * dx + dy * dy
            if a.team == b.team and squared < PUSH.along * PUSH.along:
                run_along(a, b, gives_way(match, i, j, dx, dy, math.sqrt(squared)))
            in_the_way = a.team == b.team or not (beaten(a) or beaten(b))
            if squared < 4.0 * BODY_RADIUS * BODY_RADIUS and in_the_way:
                if squared < SAME_PLACE * SAME_PLACE:
                    stumble_apart(a, b)
                else:
                    part(match, i, j, dx, dy, math.sqrt(squared))


@kernel
def gives_way(match, i, j, dx, dy, distance):
    """Return how much more player i has to give way than player j, -1 to 1; (dx, dy) leads from j to i."""
    a, b = match.players[i], match.players[j]
    ux, uy = dx / (distance + 1e-9), dy / (distance + 1e-9)
    turned = 0.5 * (ux * (a.facing_x + b.facing_x) + uy * (a.facing_y + b.facing_y))
    faster = (length(a.vx, a.vy) - length(b.vx, b.vy)) / PUSH.speed_range
    more = PUSH.speed * min(max(faster, -1.0), 1.0) - PUSH.back * turned
    if match.carrier == i:
        more -= PUSH.ball
    elif match.carrier == j:
        more += PUSH.ball
    return min(max(more, -1.0), 1.0)


@kernel
def run_along(a, b, more):
    """Let two teammates adopt a part of each other's movement; the larger `more`, the more a adopts and the less b."""
    force_a, force_b = PUSH.drag * (0.5 + PUSH.uneven * more) * DT, PUSH.drag * (0.5 - PUSH.uneven * more) * DT
    dx, dy = b.vx - a.vx, b.vy - a.vy
    a.x += force_a * dx
    a.y += force_a * dy
    b.x -= force_b * dx
    b.y -= force_b * dy


@kernel
def beaten(player):
    """Return whether a player is on the ground or has just failed to win the ball."""
    return player.down_wait > 0.0 or player.touch_wait > 0.0


@kernel
def stumble_apart(a, b):
    """Let two players who fully overlap stumble apart: b runs to the right, a only moves out of the way."""
    right = -1.0 if b.team == LEFT else 1.0
    for player, side in ((a, -right), (b, right)):
        player.y += side * STEPS_ASIDE
        player.vx, player.vy = 0.0, 0.0
        player.down_wait = STUMBLE
    b.vy = right * STUMBLE_SPEED


@kernel
def part(match, i, j, dx, dy, distance):
    """Separate two overlapping bodies and adjust their velocities; (dx, dy) leads from player j to player i.

    Teammates push past each other. Of two opponents the faster one gives way more, so that it does not displace the
    other, and both lose their closing speed.
    """
    a, b = match.players[i], match.players[j]
    nx, ny = dx / distance, dy / distance
    closing = (a.vx - b.vx) * nx + (a.vy - b.vy) * ny
    share = 0.5 + (0.5 - PUSH.least) * gives_way(match, i, j, dx, dy, distance)
    are_mates = a.team == b.team
    felt = max(-closing, 0.0) * (DT if are_mates else STEP)  # opponents do not close in further within the step
    a.pushed = min(a.pushed + share * felt, PUSH.most)
    b.pushed = min(b.pushed + (1.0 - share) * felt, PUSH.most)
    if not are_mates:
        toward_b, toward_a = a.vx * nx + a.vy * ny, b.vx * nx + b.vy * ny  # along the normal: no energy is gained
        energy_a, energy_b = toward_b * toward_b + 1e-9, toward_a * toward_a + 1e-9
        share = energy_a / (energy_a + energy_b)
    push = 2.0 * BODY_RADIUS - distance
    a.x += share * push * nx
    a.y += share * push * ny
    b.x -= (1.0 - share) * push * nx
    b.y -= (1.0 - share) * push * ny
    if closing < 0.0 and not are_mates:
        a.vx -= share * closing * nx
        a.vy -= share * closing * ny
        b.vx += (1.0 - share) * closing * nx
        b.vy += (1.0 - share) * closing * ny
