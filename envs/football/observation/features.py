"""The `features` observation: a vector for an MLP, from the viewpoint of the agent's player.

All entries are in the frame of the player's team, which attacks +x, and are scaled so that typical values are about 1.
The other players are in a fixed order: teammates, then opponents, each in the order of the match.
Read next: `observation.observer`, the other representations.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import GK, GOAL_HALF_WIDTH, HALF_LENGTH, HALF_WIDTH, LEFT, NOBODY
from regista.envs.football.control.agents import in_team_frame
from regista.envs.football.observation.units import ALOFT, FLYING, RUNNING
from regista.kernels.jit import kernel

SELF_NAMES = ("self.x", "self.y", "self.vx", "self.vy", "self.facing_x", "self.facing_y", "self.tired", "self.down")
BALL_NAMES = ("ball.dx", "ball.dy", "ball.z", "ball.vx", "ball.vy", "ball.vz", "ball.near")
OWNER_NAMES = ("owned.self", "owned.ours", "owned.theirs", "owned.nobody")
GOAL_NAMES = ("goal.direction_x", "goal.direction_y", "goal.near", "left_post.slope", "right_post.slope")
COMMAND_NAMES = (*(f"sticky.{d}" for d in range(1, 9)), "sticky.sprint", "sticky.dribble", "kick.asked", "kick.wait")
CLOCK_NAMES = ("clock",)
OTHER_NAMES = ("dx", "dy", "along", "across", "vx", "vy", "near", "down", "keeper")

BASE_SIZE = sum(map(len, (SELF_NAMES, BALL_NAMES, OWNER_NAMES, GOAL_NAMES, COMMAND_NAMES, CLOCK_NAMES)))
OTHER_SIZE = len(OTHER_NAMES)

LIMIT = 6.0  # every entry is in [-LIMIT, LIMIT]
NEARBY = 20.0  # m, unit of distances to others
CLOSE = 4.0  # m; the entry `near` is one half at this distance
LANE_LENGTH, LANE_WIDTH = 10.0, 4.0  # m, units of `along` and `across` the line from the player to the goal's center
SOON = 1.0  # s, unit of waits


def features_size(num_players: int) -> int:
    """Return the number of entries for matches of `num_players` players."""
    return BASE_SIZE + OTHER_SIZE * (num_players - 1)


def features_names(num_players: int) -> tuple[str, ...]:
    """Return the names of the entries, in order."""
    others = tuple(f"other{i}.{name}" for i in range(1, num_players) for name in OTHER_NAMES)
    return (*SELF_NAMES, *BALL_NAMES, *OWNER_NAMES, *GOAL_NAMES, *COMMAND_NAMES, *CLOCK_NAMES, *others)


@kernel
def _limited(value):
    return min(max(value, -LIMIT), LIMIT)


@kernel
def write_features(match, agent, row):
    """Write the observation of an agent into `row` `[F]` float32; zeros if it has no player."""
    i = match.agents[agent]
    if i == NOBODY:
        row[:] = 0.0
        return
    me = match.players[i]
    side = 1.0 if me.team == LEFT else -1.0  # the right team sees the pitch rotated by 180°
    at = _write_self(me, side, row, 0)
    at = _write_ball(match, me, side, row, at)
    at = _write_owner(match, i, row, at)
    goal_x, goal_y, distance = _way_to_goal(me, side)
    at = _write_goal(me, side, goal_x, goal_y, distance, row, at)
    at = _write_command(me, row, at)
    row[at] = 1.0 - match.step / match.game_duration
    at = _write_team(match, i, me.team, side, goal_x, goal_y, row, at + 1)
    _write_team(match, i, 1 - me.team, side, goal_x, goal_y, row, at)


@kernel
def _write_self(me, side, row, at):
    row[at] = side * me.x / HALF_LENGTH
    row[at + 1] = side * me.y / HALF_WIDTH
    row[at + 2] = side * me.vx / RUNNING
    row[at + 3] = side * me.vy / RUNNING
    row[at + 4] = side * me.facing_x
    row[at + 5] = side * me.facing_y
    row[at + 6] = me.tiredness
    row[at + 7] = min(me.down_wait / SOON, LIMIT)
    return at + 8


@kernel
def _write_ball(match, me, side, row, at):
    ball = match.ball
    dx, dy = side * (ball.x - me.x), side * (ball.y - me.y)
    row[at] = _limited(dx / NEARBY)
    row[at + 1] = _limited(dy / NEARBY)
    row[at + 2] = _limited(ball.z / ALOFT)
    row[at + 3] = _limited(side * ball.vx / FLYING)
    row[at + 4] = _limited(side * ball.vy / FLYING)
    row[at + 5] = _limited(ball.vz / FLYING)
    row[at + 6] = CLOSE / (CLOSE + math.sqrt(dx * dx + dy * dy))
    return at + 7


@kernel
def _write_owner(match, i, row, at):
    row[at : at + 4] = 0.0
    if match.reported_owner == NOBODY:
        row[at + 3] = 1.0
        return at + 4
    row[at] = 1.0 if match.reported_owner == i else 0.0
    row[at + 1 if match.players[match.reported_owner].team == match.players[i].team else at + 2] = 1.0
    return at + 4


@kernel
def _way_to_goal(me, side):
    """Return the unit vector from a player to the middle of the opponents' goal, and the distance in m."""
    dx, dy = HALF_LENGTH - side * me.x, -side * me.y
    distance = math.sqrt(dx * dx + dy * dy) + 1e-6
    return dx / distance, dy / distance, distance


@kernel
def _write_goal(me, side, ux, uy, distance, row, at):
    row[at], row[at + 1] = ux, uy
    row[at + 2] = CLOSE / (CLOSE + distance)
    dy, ahead = -side * me.y, max(HALF_LENGTH - side * me.x, 1.0)
    row[at + 3] = _limited((dy + GOAL_HALF_WIDTH) / ahead)
    row[at + 4] = _limited((dy - GOAL_HALF_WIDTH) / ahead)
    return at + 5


@kernel
def _write_command(me, row, at):
    row[at : at + 8] = 0.0
    if me.direction > 0:
        row[at + in_team_frame(me.team, me.direction) - 1] = 1.0
    row[at + 8] = 1.0 if me.sprint else 0.0
    row[at + 9] = 1.0 if me.dribble else 0.0
    row[at + 10] = 1.0 if me.kick > 0 else 0.0
    row[at + 11] = min(me.kick_wait / SOON, LIMIT)
    return at + 12


@kernel
def _write_team(match, i, team, side, ux, uy, row, at):
    """Write the players of a team except player i; (ux, uy) points from player i to the opponents' goal."""
    me = match.players[i]
    for index in range(match.num_players):
        other = match.players[index]
        if other.team != team or index == i:
            continue
        dx, dy = side * (other.x - me.x), side * (other.y - me.y)
        row[at] = _limited(dx / NEARBY)
        row[at + 1] = _limited(dy / NEARBY)
        row[at + 2] = _limited((dx * ux + dy * uy) / LANE_LENGTH)
        row[at + 3] = _limited((dy * ux - dx * uy) / LANE_WIDTH)
        row[at + 4] = side * other.vx / RUNNING
        row[at + 5] = side * other.vy / RUNNING
        row[at + 6] = CLOSE / (CLOSE + math.sqrt(dx * dx + dy * dy))
        row[at + 7] = min(other.down_wait / SOON, LIMIT)
        row[at + 8] = 1.0 if other.role == GK else 0.0
        at += OTHER_SIZE
    return at
