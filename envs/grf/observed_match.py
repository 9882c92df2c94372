"""From GRF's observations to our record of a match, so that all code based on MATCH works on both engines.

Fields that GRF does not report keep their initial values: the facing of standing players, and players on the ground.
Requested kicks are derived from the actions, as in our simulator, and the time of the kick from the ball's velocity.
Read next: `regista.envs.football.state`, the record; `grf.worker`, GRF's record.
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
from regista.envs.football.control.actions import hold_kick
from regista.envs.football.control.agents import choose_closest
from regista.envs.football.control.episode import end_episode
from regista.envs.football.control.reward import add_checkpoint_rewards
from regista.envs.football.observation.units import SPIN_UNIT, UNIT_X, UNIT_Y
from regista.envs.football.physics.possession import forget_kick
from regista.envs.football.physics.vectors import length
from regista.envs.grf.worker import TEAM
from regista.kernels.jit import kernel

STANDING = 0.3  # m/s; below, a player's velocity does not define the facing


class Kicked(NamedTuple):
    """How a kick is recognized a step later; a carrier's touch gives the ball at most 5 m/s relative to the player."""

    faster: float = 7.0  # m/s, ball relative to player
    within: float = 5.0  # m between ball and player


KICKED = Kicked()
IN_HANDS = 0.5  # m; a keeper who owns a ball at this height or above holds it


@kernel
def read_start(match, seen, controllers):
    """Write the initial state of a match in GRF into its record, which `kick_off` has filled."""
    _read_bodies(match, seen)
    _read_owner(match, seen)
    read_agents(match, seen, controllers)


@kernel
def read_step(match, seen, controllers):
    """Write the result of a step into the record: all fields that our simulator writes before the monitors run."""
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
        match.ended, match.truncated = DURATION, True  # GRF plays no further step
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
        reported = seen.players[TEAM * player.team + player.shirt]
        player.x, player.y = reported.x * UNIT_X, reported.y * UNIT_Y
        player.vx, player.vy = reported.dx * UNIT_X / STEP, reported.dy * UNIT_Y / STEP
        speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
        if speed > STANDING:
            player.facing_x, player.facing_y = player.vx / speed, player.vy / speed
        player.tiredness = reported.tired
        player.has_left = reported.is_active == 0
        player.cards = 2 if player.has_left else 1 if reported.has_card != 0 else 0
        player.direction = reported.direction if reported.controller != NOBODY else 0
        player.sprint = reported.controller != NOBODY and reported.sprint != 0
        player.dribble = reported.controller != NOBODY and reported.dribble != 0


@kernel
def _read_owner(match, seen):
    """Write the owner of the ball, and each team's designated player."""
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
    """Remember the kicks that agents have requested until the ball leaves the foot or the request expires."""
    for i in range(match.num_players):
        player = match.players[i]
        if player.kick != 0 and (player.agent == NOBODY or kicked(match, player)):
            forget_kick(player)
        elif player.agent != NOBODY and (player.kick != 0 or i in (match.carrier, match.chaser[player.team])):
            hold_kick(player, player.action)


@kernel
def kicked(match, player):
    """Return whether the ball has just left a player's foot: it is faster than after a carrier's touch."""
    ball = match.ball
    away = length(ball.x - player.x, ball.y - player.y)
    return away < KICKED.within and length(ball.vx - player.vx, ball.vy - player.vy) > KICKED.faster


@kernel
def player_at(match, row):
    """Return the player in a row of GRF's observation, -1 for none."""
    for i in range(match.num_players):
        if TEAM * match.players[i].team + match.players[i].shirt == row:
            return i
    return NOBODY


@kernel
def read_agents(match, seen, controllers):
    """Give each agent the player that its next action moves; `controllers` [2] counts GRF's agents of each team.

    An `active` agent has the player that GRF has given to its only agent, or GRF's designated player if GRF has an
    agent for every player; the other modes work as in our simulator.
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
    """Let an agent control a player, or none."""
    if match.agents[agent] != NOBODY:
        match.players[match.agents[agent]].agent = NOBODY
    match.agents[agent] = player
    if player != NOBODY:
        match.players[player].agent = agent
