"""The pull of a free ball on an agent's player: which player it attracts, how strongly, and where they meet.

As in Google Research Football, the first player at the ball runs to it whatever direction is held, and waits for the
ball if clearly first. If an opponent is first, the player's velocity mixes the held direction and the way to the ball.
Read next: `control.actions`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import DIRECTION_X, DIRECTION_Y, NOBODY
from regista.envs.football.physics.pitch import forward
from regista.envs.football.physics.possession import ball_speed
from regista.envs.football.physics.vectors import apart, length, toward
from regista.envs.football.skills.shots import eased
from regista.envs.football.skills.steering import AWAIT, await_ball, chase
from regista.kernels.jit import kernel


class Pull(NamedTuple):
    """How a free ball attracts a player who is not the first at it."""

    patience: float = 0.2  # s added to both teams' times to the ball
    too_late: float = 0.5  # ratio of the opponents' time to the player's, below which there is no pull
    curve: float = 0.8  # exponent of the similarity of the directions
    memory: float = 2.0  # s for which the last player to touch the ball is favored
    touched: float = 0.4  # exponent of the share of `memory` that is left
    soon: float = 1.7  # s to the ball at most, for the pull on that player
    standing: float = 1.8  # m/s, below which a player stands
    at_rest: float = 0.5  # m/s, below which a player or a ball is at rest
    body: float = 0.75  # m to a ball at rest, at or beyond which a standing player puts out a leg for it,
    leg: float = 0.83  # m, and below which


# Documented by Google Research Football; checked against its episodes, continued from the state after each step.
PULL = Pull()


@kernel
def follow_magnet(match, i):
    """Turn the desired velocity of player i towards a free ball, or towards the player's own ball far from the feet."""
    player = match.players[i]
    if player.kick == 0 and (match.carrier not in (NOBODY, i) or match.chaser[player.team] != i):
        return
    action_x, action_y = player.desired_vx, player.desired_vy
    goes = is_ours(match, player.team)
    if at_hand(match, player):
        return
    if player.kick == 0 and goes and awaits(match, i):
        return
    chase(match, i, player.top_speed)
    if goes:
        return
    share = pull(match, i)
    player.desired_vx = share * player.desired_vx + (1.0 - share) * action_x
    player.desired_vy = share * player.desired_vy + (1.0 - share) * action_y


@kernel
def at_hand(match, player):
    """Return whether a standing player with no direction held puts out a leg for a resting ball, instead of running."""
    ball = match.ball
    return (
        player.direction == 0
        and length(player.vx, player.vy) < PULL.at_rest
        and ball_speed(ball) < PULL.at_rest
        and PULL.body <= apart(ball, player) < PULL.leg
    )


@kernel
def awaits(match, i):
    """Let player i, if clearly first at a moving ball, meet it at the point that suits the held direction best; return
    whether it does.
    """
    player = match.players[i]
    time = match.arrival[player.team]
    if match.carrier == i or in_time_by(match, player, time) < AWAIT.in_time:
        return False
    ux, uy = action_direction(player)
    return await_ball(match.ball, player, time, ux, uy)


@kernel
def action_direction(player):
    """Return the unit vector of the direction that a player holds, or of the player's facing if none is held."""
    if player.direction == 0:
        return player.facing_x, player.facing_y
    return DIRECTION_X[player.direction], DIRECTION_Y[player.direction]


@kernel
def in_time_by(match, player, time):
    """Return the ratio of the opponents' time to the ball to the player's `time` in s: above 1 the player is first."""
    return (match.arrival[1 - player.team] + PULL.patience) / (time + PULL.patience)


@kernel
def is_ours(match, team):
    """Return whether a team is first at a free ball: its first player is sooner, or was and is not clearly later."""
    return match.team_in_possession == team


@kernel
def pull(match, i):
    """Return how strongly, 0 to 1, a free ball attracts the first player of a team if an opponent is sooner.

    The pull falls with the delay and with the angle to the held direction, unless the player has just touched the ball.
    """
    player = match.players[i]
    time = match.arrival[player.team]
    in_time = in_time_by(match, player, time)
    if in_time <= PULL.too_late:
        return 0.0
    ux, uy = action_direction(player)
    to_x, to_y = toward(player.desired_vx, player.desired_vy)
    alike = 1.0 - 0.5 * math.acos(min(max(ux * to_x + uy * to_y, -1.0), 1.0)) / math.pi
    forwards = 0.5 * (1.0 + forward(player.team) * ux)
    share = math.sqrt(2.0 * (in_time - PULL.too_late)) * eased(alike, PULL.curve) * forwards
    if match.last_touch == i and match.kick_age < PULL.memory and time < PULL.soon:
        touched = (1.0 - match.kick_age / PULL.memory) ** PULL.touched
        share = max(share, touched * math.sqrt(alike))
    return min(share, 1.0)
