"""Where everybody stands when play restarts: the team's formation, laid into a part of the pitch and drawn to the ball.

The parts and the strengths are Google Research Football's; the shape is that of `formation`, in which everybody has his
slot. "Ahead" is the way that a team attacks, so one table serves both. Read next: `rules.restarts`.
"""

from __future__ import annotations

import math

from envs.football.constants import (
    CORNER,
    FREE_KICK,
    GK,
    GOAL_KICK,
    HALF_LENGTH,
    HALF_WIDTH,
    NOBODY,
    THROW_IN,
)
from envs.football.physics.pitch import forward, own_goal_x
from envs.football.physics.vectors import apart, length
from envs.football.rules.whistle import move_to
from scenic_lite.kernels.jit import kernel

OUTERMOST = 0.83  # of the block's half width, where the outermost slots are
KEEPER_X = 0.98 * HALF_LENGTH  # m, where keepers wait for a restart
NEAR = 50.0  # m, players whose places are nearer to the ball than this are drawn to it
DISTANCE, THROW_IN_DISTANCE = 9.15, 2.0  # m that opponents keep from the ball
BOX_X, PENALTY_ROOM = HALF_LENGTH - 16.5, 0.5  # m: at a penalty all but two wait this far outside box and arc
FOLD = 0.3  # m that they wait further out for each m that their place would have been in the box
SAME_PLACE, SIDESTEP = 0.05, 0.4  # m
EVEN = 1e-6  # m: who stand no further apart than this are equally far from the ball, as those kept away from it are
WALL_RANGE, WALL_SIZE, WALL_ANGLE = 40.0, 3, 0.08  # m to the goal; players; rad between them


@kernel
def place_players(match):
    """Put everybody but the taker where he waits for the restart that is due."""
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
    """Return the place of player i in his team's block for this restart: his slot, drawn to what matters."""
    player, ball = match.players[i], match.ball
    back, front, focus, pull, wide, focus_y, pull_y, near = block(match.game_mode, taking, way * ball.x)
    ahead = back + 0.5 * (1.0 + player.slot_x) * (front - back)
    shift = 0.25 * ball.y if match.game_mode == THROW_IN else 0.0
    y = OUTERMOST * player.slot_y * wide * HALF_WIDTH + shift
    far = length(way * ball.x - ahead, 0.8 * (ball.y - y))
    ahead += pull * max(1.0 - abs(focus - ahead) / (front - back), 0.0) * (focus - ahead)
    target_y = focus_y * ball.y
    share = pull_y * (0.2 + 0.8 * abs(target_y) / HALF_WIDTH)
    y += share * max(1.0 - 0.5 * abs(target_y - y) / (wide * HALF_WIDTH), 0.0) * (target_y - y)
    draw = near * max(1.0 - far / NEAR, 0.0)
    ahead += draw * (way * ball.x - ahead)
    y += draw * 0.6 * (ball.y - y)
    limit_x, limit_y = HALF_LENGTH - 1.0, HALF_WIDTH - 1.0
    return way * min(max(ahead, -limit_x), limit_x), min(max(y, -limit_y), limit_y)


@kernel
def block(mode, taking, ball):
    """Return the block of a team, for a ball this far ahead.

    Back, front, focus ahead (m) and its pull; half its width as a share of the pitch's; the focus across as a share of
    the ball's y, its pull; and the pull of the ball itself.
    """
    along = 0.5 + 0.5 * min(max(ball / HALF_LENGTH, -1.0), 1.0)  # 0 at the own goal, 1 at the other
    if mode == GOAL_KICK:
        back, front = (-27.5, 11.0) if taking else (-22.0, 5.5)
        return back, front, back, 0.0, 0.7, 0.0, 0.0, 0.0
    if mode == CORNER:
        if taking:
            return 11.0, 52.8, 44.9, 0.7, 0.6, 0.1, 0.7, 0.3
        return -53.9, -27.5, -50.7, 0.8, 0.6, 0.1, 0.9, 0.3
    if mode == THROW_IN:
        if taking:
            return ball - 30.0, ball + 20.0, ball + 4.0, 0.4, 0.75, 0.996, 0.6, 0.7
        return ball - 30.0, ball + 15.0, ball - 16.0, 0.2, 0.75, 0.95, 0.5, 0.7
    if mode == FREE_KICK:
        if taking:
            back, front = -38.5 + 38.5 * along, 16.5 + 38.5 * along
            return back, front, ball + 10.0, 0.5 + 0.2 * along, 0.7, 0.4, 0.6 + 0.2 * along, 0.4
        back, front = -55.0 + 33.0 * along, -27.5 + 44.0 * along
        return back, front, ball - 20.0, 0.6 - 0.4 * along, 0.7, 0.2, 0.8 - 0.4 * along, 0.4
    if taking:  # a penalty
        return ball - 50.0, ball + 10.0, ball, 0.6, 0.8, 0.0, 0.8, 0.0
    return ball - 11.0, ball + 20.0, ball, 1.0, 0.8, 0.0, 1.0, 0.0


@kernel
def untangle(match):
    """Move everybody who stands exactly on another further from the ball, to where nobody stands."""
    for i in range(1, match.num_players):
        player = match.players[i]
        back = player.x - match.ball.x
        step = math.copysign(SIDESTEP, back if back != 0.0 else -forward(player.team))
        for _ in range(i):
            if not shares_place(match, i):
                break
            player.x += step


@kernel
def shares_place(match, i):
    """Return whether somebody before player i stands where he does."""
    player, others = match.players[i], 0
    for j in range(i):
        others += apart(player, match.players[j]) < SAME_PLACE
    return others > 0 and not player.has_left


@kernel
def kept_away(match, x, y, way):
    """Return the place nearest to (x, y) that is far enough from the ball; at a penalty, outside the box too."""
    ball = match.ball
    distance = THROW_IN_DISTANCE if match.game_mode == THROW_IN else DISTANCE
    if match.game_mode > THROW_IN:
        distance += PENALTY_ROOM
        over = abs(x) - BOX_X + PENALTY_ROOM
        if over > 0.0:  # a little further out the further in they were, so that nobody stands on another
            x = math.copysign(BOX_X - PENALTY_ROOM - FOLD * over, x)
    dx, dy = x - ball.x, y - ball.y
    away = length(dx, dy)
    if away >= distance:
        return x, y
    if away < 1e-6:
        dx, dy, away = -way, 0.0, 1.0
    x, y = ball.x + distance * dx / away, ball.y + distance * dy / away
    if abs(x) < HALF_LENGTH and abs(y) < HALF_WIDTH:
        return x, y
    inward = math.copysign(1.0, -ball.y)  # the other way is off the pitch: into it, across
    return ball.x - math.copysign(0.5 * distance, ball.x), ball.y + inward * 0.9 * distance


@kernel
def build_wall(match):
    """Line up the three outfield opponents nearest to a free kick near their goal between ball and goal."""
    ball, team = match.ball, 1 - match.restart_team
    goal_x = own_goal_x(team)
    if length(goal_x - ball.x, ball.y) >= WALL_RANGE:
        return
    angle = math.atan2(-ball.y, goal_x - ball.x)
    chosen, side = 0, 0.0
    for k in range(WALL_SIZE):
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
        if k == 1:  # the second nearest goes to his own side of the first, the third to the other
            player = match.players[best]
            across = (player.y - ball.y) * math.cos(angle) - (player.x - ball.x) * math.sin(angle)
            side = WALL_ANGLE if across >= 0.0 else -WALL_ANGLE
        here = angle + (0.0, side, -side)[k]
        move_to(match, best, ball.x + DISTANCE * math.cos(here), ball.y + DISTANCE * math.sin(here))
