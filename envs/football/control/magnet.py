"""The pull of a free ball on the player whom an agent moves: whom it pulls, how much, and where he meets it.

As in Google Research Football, the first of all at the ball goes for it whatever his keys say, and at his ease if he
is clearly the first; who is not has his keys' way and the ball's mixed. Read next: `control.actions`.
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
    """How a free ball pulls a player who is not the first at it."""

    patience: float = 0.2  # s that both teams' times to the ball are longer than they are
    too_late: float = 0.5  # of the opponents' time by his: up to which it does not pull him
    curve: float = 0.8  # of how alike the ways are
    memory: float = 2.0  # s for which he who touched it last remembers that,
    touched: float = 0.4  # to this power,
    soon: float = 1.7  # s to the ball at most
    standing: float = 1.8  # m/s, slower he stands
    at_rest: float = 0.5  # m/s, slower rests who or what does
    body: float = 0.75  # m to a ball that rests, from where on who stands puts out a leg for it,
    leg: float = 0.83  # and up to where


# Documented of Google Research Football; checked by its own episodes, played on from where they were after each step.
PULL = Pull()


@kernel
def follow_magnet(match, i):
    """Turn the velocity that player i's keys ask for towards a free ball, or his own far from his feet, as much as that
    pulls him.
    """
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
    """Return whether a player who stands, with no direction held, puts out a leg for a resting ball, with no run."""
    ball = match.ball
    return (
        player.direction == 0
        and length(player.vx, player.vy) < PULL.at_rest
        and ball_speed(ball) < PULL.at_rest
        and PULL.body <= apart(ball, player) < PULL.leg
    )


@kernel
def awaits(match, i):
    """Let player i, who is clearly the first at a ball that comes, meet it where that suits his keys best; return
    whether he does.
    """
    player = match.players[i]
    time = match.arrival[player.team]
    if match.carrier == i or in_time_by(match, player, time) < AWAIT.in_time:
        return False
    ux, uy = action_direction(player)
    return await_ball(match.ball, player, time, ux, uy)


@kernel
def action_direction(player):
    """Return the unit vector of a player's keys, or of where he looks if they have no direction."""
    if player.direction == 0:
        return player.facing_x, player.facing_y
    return DIRECTION_X[player.direction], DIRECTION_Y[player.direction]


@kernel
def in_time_by(match, player, time):
    """Return how well a player is in time for the ball, at which he is in `time` s: above 1 the first."""
    return (match.arrival[1 - player.team] + PULL.patience) / (time + PULL.patience)


@kernel
def is_ours(match, team):
    """Return whether a free ball is a team's: its first is there sooner, or has been so and is not clearly later."""
    return match.team_in_possession == team


@kernel
def pull(match, i):
    """Return how much, 0 to 1, a free ball pulls the first of his team at it where an opponent is sooner.

    The less the later he is and the more his keys lead elsewhere, unless he has just touched it.
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
