"""Positions at a restart: the team's formation, placed into a part of the pitch and moved towards the ball.

The parts and strengths are Google Research Football's; the shape is that of `formation`, with a slot for each player.
"Ahead" is the direction of attack, so one table serves both teams. Read next: `rules.restarts`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import (
    FREE_KICK,
    GK,
    GOAL_KICK,
    HALF_LENGTH,
    HALF_WIDTH,
    NOBODY,
    THROW_IN,
)
from regista.envs.football.physics.pitch import forward, own_goal_x
from regista.envs.football.physics.vectors import apart, length
from regista.envs.football.rules.whistle import move_to
from regista.kernels.jit import kernel


class Block(NamedTuple):
    """The part of the pitch into which a team's formation is placed, and the pull on it.

    Lengths are m ahead of the middle of the pitch; fields named "along" are added in proportion to the ball's position
    from the own goal to the other.
    """

    back: float  # m
    back_along: float  # m
    front: float  # m
    front_along: float  # m
    follows: float  # share of the ball's position that is added to back and front
    focus: float  # m, the focus towards which the formation is pulled
    focus_follows: float  # share of the ball's position that is added to the focus
    pull: float  # strength of the pull
    pull_along: float
    wide: float  # half the block's width, as a share of the pitch's
    focus_y: float  # the focus across, as a share of the ball's position
    pull_y: float
    pull_y_along: float
    near: float  # strength of the ball's own pull


class Draw(NamedTuple):
    """How slots are placed into the block, and how far each slot is pulled."""

    throw_shift: float = 0.25  # share of the ball's lateral position by which all slots are moved at a throw-in
    across: float = 0.8  # weight of a lateral distance
    across_least: float = 0.2  # share of the pull across for a ball in the middle,
    across_more: float = 0.8  # added to this share if the ball is at the side line
    across_fades: float = 0.5  # share of the pull across that is lost half a block's width away
    near: float = 50.0  # m to the ball, within which players are pulled to it
    near_across: float = 0.6  # weight of this pull across
    inside: float = 1.0  # m inside the lines


class Keep(NamedTuple):
    """Minimum distances at a restart."""

    ball: float = 9.15  # m that opponents keep from the ball
    throw: float = 2.0  # m, the same at a throw-in
    box_x: float = HALF_LENGTH - 16.5  # m: at a penalty all but two wait outside the box and the arc,
    penalty_room: float = 0.5  # m further away than usual,
    fold: float = 0.3  # m more for each m inside the box
    corner_back: float = 0.5  # share of the distance that a player who would have to leave the pitch keeps backwards
    corner_in: float = 0.9  # and towards the middle
    same_place: float = 0.05  # m; players nearer to each other have the same position
    sidestep: float = 0.4  # m, step away from such a position


class Wall(NamedTuple):
    """The wall before a free kick near the goal."""

    range: float = 40.0  # m to the goal
    size: int = 3  # players
    angle: float = 0.08  # rad between them


# Parts of the pitch and strengths are Google Research Football's; checked by `lab.benchmarks --suite grf`, family
# matches.
BLOCKS = (  # for each restart: the team that takes it, then the other team
    Block(-27.5, 0.0, 11.0, 0.0, 0.0, -27.5, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 0.0),  # a goal kick
    Block(-22.0, 0.0, 5.5, 0.0, 0.0, -22.0, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 0.0),
    Block(-38.5, 38.5, 16.5, 38.5, 0.0, 10.0, 1.0, 0.5, 0.2, 0.7, 0.4, 0.6, 0.2, 0.4),  # a free kick
    Block(-55.0, 33.0, -27.5, 44.0, 0.0, -20.0, 1.0, 0.6, -0.4, 0.7, 0.2, 0.8, -0.4, 0.4),
    Block(11.0, 0.0, 52.8, 0.0, 0.0, 44.9, 0.0, 0.7, 0.0, 0.6, 0.1, 0.7, 0.0, 0.3),  # a corner
    Block(-53.9, 0.0, -27.5, 0.0, 0.0, -50.7, 0.0, 0.8, 0.0, 0.6, 0.1, 0.9, 0.0, 0.3),
    Block(-30.0, 0.0, 20.0, 0.0, 1.0, 4.0, 1.0, 0.4, 0.0, 0.75, 0.996, 0.6, 0.0, 0.7),  # a throw-in
    Block(-30.0, 0.0, 15.0, 0.0, 1.0, -16.0, 1.0, 0.2, 0.0, 0.75, 0.95, 0.5, 0.0, 0.7),
    Block(-50.0, 0.0, 10.0, 0.0, 1.0, 0.0, 1.0, 0.6, 0.0, 0.8, 0.0, 0.8, 0.0, 0.0),  # a penalty
    Block(-11.0, 0.0, 20.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.8, 0.0, 1.0, 0.0, 0.0),
)
DRAW, KEEP, WALL = Draw(), Keep(), Wall()
KEEPER_X = 0.98 * HALF_LENGTH  # m, where keepers wait for a restart
EVEN = 1e-6  # m: distances to the ball within this are equal, such as those of players who are kept away from it


@kernel
def place_players(match):
    """Place all players except the taker for the pending restart."""
    for i in range(match.num_players):
        player = match.players[i]
        ahead = forward(player.team)
        if player.role == GK:
            move_to(match, i, -ahead * KEEPER_X, 0.0)
            continue
        taking = player.team == match.restart_team
        x, y = block_place(match, i, taking, ahead)
        if not taking or match.game_mode > THROW_IN:
            x, y = kept_away(match, x, y, ahead)
        move_to(match, i, x, y)
    if match.game_mode == FREE_KICK:
        build_wall(match)
    untangle(match)


@kernel
def block_place(match, i, taking, way):
    """Return the position of player i for this restart: the slot in the block, pulled to the focus and the ball."""
    player, ball = match.players[i], match.ball
    block = BLOCKS[2 * (match.game_mode - GOAL_KICK) + (0 if taking else 1)]
    along = 0.5 + 0.5 * min(max(way * ball.x / HALF_LENGTH, -1.0), 1.0)  # 0 at the own goal, 1 at the other
    back = block.back + block.back_along * along + block.follows * (way * ball.x)
    front = block.front + block.front_along * along + block.follows * (way * ball.x)
    focus = block.focus + block.focus_follows * (way * ball.x)
    pull, pull_y = block.pull + block.pull_along * along, block.pull_y + block.pull_y_along * along
    ahead = back + 0.5 * (1.0 + player.slot_x) * (front - back)
    shift = DRAW.throw_shift * ball.y if match.game_mode == THROW_IN else 0.0
    y = way * player.slot_y * block.wide * HALF_WIDTH + shift
    far = length(way * ball.x - ahead, DRAW.across * (ball.y - y))
    ahead += pull * max(1.0 - abs(focus - ahead) / (front - back), 0.0) * (focus - ahead)
    target_y = block.focus_y * ball.y
    share = pull_y * (DRAW.across_least + DRAW.across_more * abs(target_y) / HALF_WIDTH)
    fades = DRAW.across_fades * abs(target_y - y) / (block.wide * HALF_WIDTH)
    y += share * max(1.0 - fades, 0.0) * (target_y - y)
    draw = block.near * max(1.0 - far / DRAW.near, 0.0)
    ahead += draw * (way * ball.x - ahead)
    y += draw * DRAW.near_across * (ball.y - y)
    limit_x, limit_y = HALF_LENGTH - DRAW.inside, HALF_WIDTH - DRAW.inside
    return way * min(max(ahead, -limit_x), limit_x), min(max(y, -limit_y), limit_y)


@kernel
def untangle(match):
    """Move each player who stands exactly on another one away from the ball, to a free position."""
    for i in range(1, match.num_players):
        player = match.players[i]
        back = player.x - match.ball.x
        step = math.copysign(KEEP.sidestep, back if back != 0.0 else -forward(player.team))
        for _ in range(i):
            if not shares_place(match, i):
                break
            player.x += step


@kernel
def shares_place(match, i):
    """Return whether a player before i has the same position."""
    player, others = match.players[i], 0
    for j in range(i):
        others += apart(player, match.players[j]) < KEEP.same_place
    return others > 0 and not player.has_left


@kernel
def kept_away(match, x, y, way):
    """Return the point nearest to (x, y) that is far enough from the ball, and at a penalty also outside the box."""
    ball = match.ball
    distance = KEEP.throw if match.game_mode == THROW_IN else KEEP.ball
    if match.game_mode > THROW_IN:
        distance += KEEP.penalty_room
        over = abs(x) - KEEP.box_x + KEEP.penalty_room
        if over > 0.0:  # further out the further in, so that positions stay distinct
            x = math.copysign(KEEP.box_x - KEEP.penalty_room - KEEP.fold * over, x)
    dx, dy = x - ball.x, y - ball.y
    away = length(dx, dy)
    if away >= distance:
        return x, y
    if away < 1e-6:
        dx, dy, away = -way, 0.0, 1.0
    x, y = ball.x + distance * dx / away, ball.y + distance * dy / away
    if abs(x) < HALF_LENGTH and abs(y) < HALF_WIDTH:
        return x, y
    inward = math.copysign(1.0, -ball.y)  # the direct way leaves the pitch: move back and across instead
    return ball.x - math.copysign(KEEP.corner_back * distance, ball.x), ball.y + inward * KEEP.corner_in * distance


@kernel
def build_wall(match):
    """Line up the three outfield opponents nearest to a free kick between ball and goal, if it is near their goal.

    If the wall would stand beyond the goal line, as it would in GRF, players are only kept away from the ball.
    """
    ball, team = match.ball, 1 - match.restart_team
    goal_x = own_goal_x(team)
    if length(goal_x - ball.x, ball.y) >= WALL.range:
        return
    angle = math.atan2(-ball.y, goal_x - ball.x)
    if abs(ball.x + KEEP.ball * math.cos(angle)) > HALF_LENGTH:
        return
    chosen, side = 0, 0.0
    for k in range(WALL.size):
        best, nearest = NOBODY, math.inf
        for i in range(match.num_players):
            player = match.players[i]
            if player.team != team or player.role == GK or player.has_left or chosen >> i & 1 == 1:
                continue
            away = length(player.x - ball.x, player.y - ball.y)
            if away < nearest - EVEN:
                best, nearest = i, away
        if best == NOBODY:
            return
        chosen |= 1 << best
        if k == 1:  # the second nearest stands on its own side of the first, the third on the other side
            player = match.players[best]
            across = (player.y - ball.y) * math.cos(angle) - (player.x - ball.x) * math.sin(angle)
            side = WALL.angle if across >= 0.0 else -WALL.angle
        here = angle + (0.0, side, -side)[k]
        move_to(match, best, ball.x + KEEP.ball * math.cos(here), ball.y + KEEP.ball * math.sin(here))
