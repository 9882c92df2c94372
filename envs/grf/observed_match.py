"""From what the real engine shows to our record of a match: everything that stands on MATCH then works on both engines.

What the engine does not tell stays as it was at the start: where bodies look while they stand, who lies on the ground.
That a kick is asked for follows from the keys, as in our own simulator, and its end from the ball. Read next:
`regista.envs.football.state`, the record; `grf.worker`, the other one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import (
    ACTIVE,
    BALL_RADIUS,
    CLOSEST,
    DURATION,
    GK,
    LEFT,
    NO_FAULT,
    NOBODY,
    RUNNING,
    STEP,
)
from regista.envs.football.control.agents import choose_closest
from regista.envs.football.control.episode import end_episode
from regista.envs.football.control.keys import hold_kick
from regista.envs.football.control.reward import add_checkpoint_rewards
from regista.envs.football.observation.units import SPIN_UNIT, UNIT_X, UNIT_Y
from regista.envs.football.physics.possession import forget_kick
from regista.envs.football.physics.vectors import length
from regista.envs.grf.worker import TEAM
from regista.kernels.jit import kernel

STANDING = 0.3  # m/s below which a body's velocity does not tell where it looks


class Kicked(NamedTuple):
    """By what a kick is recognised, after the step in which it was: not a touch of a run, at most 5 m/s from him."""

    faster: float = 7.0  # m/s, ball against player
    within: float = 5.0  # m between them


KICKED = Kicked()
IN_HANDS = 0.5  # m, height of the ball from which a keeper who has it holds it


@kernel
def read_start(match, seen, controllers):
    """Write a match that the engine has just begun into its record, which `kick_off` has filled."""
    _read_bodies(match, seen)
    _read_owner(match, seen)
    read_agents(match, seen, controllers)


@kernel
def read_step(match, seen, controllers):
    """Write what a step has brought into the record of its match: all that our own step writes, up to the monitors."""
    match.step += 1
    _read_bodies(match, seen)
    match.goal = 0
    for team in range(2):
        if seen.score[team] > match.score[team]:
            match.goal = 1 if team == LEFT else -1
        match.score[team] = seen.score[team]
    match.game_mode = seen.game_mode
    last = match.last_owned_team
    _read_owner(match, seen)
    follow_kicks(match)
    match.possession_changed = last != NOBODY and match.last_owned_team != last
    if match.half == 0 and match.step >= match.second_half:
        match.half = 1
    end_episode(match)
    if seen.done != 0 and match.ended == RUNNING and match.fault == NO_FAULT:
        match.ended, match.truncated = DURATION, True  # the engine plays it no further
    read_agents(match, seen, controllers)
    add_checkpoint_rewards(match)


@kernel
def _read_bodies(match, seen):
    ball = match.ball
    ball.x, ball.y, ball.z = seen.ball[0] * UNIT_X, seen.ball[1] * UNIT_Y, seen.ball[2]
    ball.vx, ball.vy = seen.ball_direction[0] * UNIT_X / STEP, seen.ball_direction[1] * UNIT_Y / STEP
    ball.vz = seen.ball_direction[2] / STEP
    spin = BALL_RADIUS / SPIN_UNIT
    ball.spin_x, ball.spin_y = seen.ball_rotation[1] * spin, -seen.ball_rotation[0] * spin
    for i in range(match.num_players):
        player = match.players[i]
        there = seen.players[TEAM * player.team + player.shirt]
        player.x, player.y = there.x * UNIT_X, there.y * UNIT_Y
        player.vx, player.vy = there.dx * UNIT_X / STEP, there.dy * UNIT_Y / STEP
        speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
        if speed > STANDING:
            player.facing_x, player.facing_y = player.vx / speed, player.vy / speed
        player.tiredness = there.tired
        player.has_left = there.is_active == 0
        player.cards = 2 if player.has_left else 1 if there.has_card != 0 else 0
        player.direction = there.direction if there.controller != NOBODY else 0
        player.sprint = there.controller != NOBODY and there.sprint != 0
        player.dribble = there.controller != NOBODY and there.dribble != 0


@kernel
def _read_owner(match, seen):
    """Write who has the ball, and whom each team has designated to win it."""
    match.reported_owner = NOBODY
    if seen.owned_team != NOBODY:
        match.reported_owner = player_at(match, TEAM * seen.owned_team + seen.owned_player)
    owner = match.reported_owner
    match.carrier = owner
    match.keeper_holding = NOBODY
    if owner != NOBODY:
        match.last_touch = match.last_carrier = owner
        match.last_owned_team = match.players[owner].team
        if match.players[owner].role == GK and match.ball.z > IN_HANDS:
            match.keeper_holding = owner
    for team in range(2):
        match.chaser[team] = match.designated[team] = player_at(match, TEAM * team + seen.designated[team])


@kernel
def follow_kicks(match):
    """Remember the kicks that agents have asked for until the ball has left the foot, or they are forgotten."""
    for i in range(match.num_players):
        player = match.players[i]
        if player.kick != 0 and (player.agent == NOBODY or kicked(match, player)):
            forget_kick(player)
        elif player.agent != NOBODY and (player.kick != 0 or i in (match.carrier, match.chaser[player.team])):
            hold_kick(player, player.action)


@kernel
def kicked(match, player):
    """Return whether the ball has just left a player's foot: it is faster than he would knock it on."""
    ball = match.ball
    away = length(ball.x - player.x, ball.y - player.y)
    return away < KICKED.within and length(ball.vx - player.vx, ball.vy - player.vy) > KICKED.faster


@kernel
def player_at(match, row):
    """Return the player of a row of the engine's, -1 for none."""
    for i in range(match.num_players):
        if TEAM * match.players[i].team + match.players[i].shirt == row:
            return i
    return NOBODY


@kernel
def read_agents(match, seen, controllers):
    """Give each agent the player whom its next action moves; `controllers` [2] are the engine's agents of each team.

    An agent who is `active` has the player whom the engine has given to its own only agent, or, where the engine has
    one for every player, whom it has designated to win the ball; the other modes are those of our own simulator.
    """
    first, number = 0, 0
    for team in range(2):
        if match.control[team] == ACTIVE:
            chosen = match.chaser[team]
            if controllers[team] == 1:
                chosen = player_at(match, seen.agents[number])
            _give(match, first, chosen)
        elif match.control[team] == CLOSEST:
            choose_closest(match, team, first)
        first += match.num_agents[team]
        number += controllers[team]


@kernel
def _give(match, agent, player):
    """Let an agent have a player, or nobody."""
    if match.agents[agent] != NOBODY:
        match.players[match.agents[agent]].agent = NOBODY
    match.agents[agent] = player
    if player != NOBODY:
        match.players[player].agent = agent
