"""The agents' part of a step: apply their actions to their players, then assign the next player to each agent.

The assignment is the last part of a step, so an agent observes the player that its next action moves. Read next:
`control.control_modes`, the names of the modes; `control.actions`, which turns actions into desired velocities and
kicks.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import (
    ACTIVE,
    BAD_ACTION,
    BUILTIN_AI,
    BY_PROGRAM,
    CLOSEST,
    LEFT,
    NO_ACTION,
    NOBODY,
    NUM_ACTIONS,
    RIGHT,
)
from regista.envs.football.control.actions import desired_action, main_action
from regista.envs.football.control.active_player import choose_active
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


@kernel
def assign_actions(match, actions):
    """Give the agents' players their actions `[A]`, and all other players the built-in AI's.

    BY_PROGRAM leaves an agent's player to the program, or to the built-in AI if the program has no command.
    """
    for i in range(match.num_players):
        match.players[i].action = BUILTIN_AI
    for agent in range(num_agents(match)):
        action = actions[agent]
        if match.engine.sticky_noise > 0.0 and match.step > 0 and uniform(match) < match.engine.sticky_noise:
            last = match.last_actions[agent]
            action = action if last == NO_ACTION else last
        match.last_actions[agent] = action
        if action == BY_PROGRAM:
            continue
        if not 0 <= action < NUM_ACTIONS:
            match.fault = BAD_ACTION
            action = 0
        if match.agents[agent] != NOBODY:
            player = match.players[match.agents[agent]]
            player.action = in_team_frame(player.team, action)


@kernel
def apply_commanded_actions(match):
    """Apply the program's commands to players of agents that leave them to the program, one action per step."""
    for agent in range(num_agents(match)):
        i = match.agents[agent]
        if match.last_actions[agent] == BY_PROGRAM and i != NOBODY and match.players[i].action != BUILTIN_AI:
            player = match.players[i]
            player.action = main_action(player, player.action)
            match.last_actions[agent] = in_team_frame(player.team, player.action)


@kernel
def record_desired_actions(match):
    """Record, for agents whose player the built-in AI moved, the action nearest to its decision."""
    for agent in range(num_agents(match)):
        i = match.agents[agent]
        if match.last_actions[agent] != BY_PROGRAM:
            continue
        match.last_actions[agent] = NO_ACTION
        if i != NOBODY:
            player = match.players[i]
            match.last_actions[agent] = in_team_frame(player.team, desired_action(player, match.step))


@kernel
def set_actions(match, actions):
    """Give every player an action, `actions` [P]: 0..18, BUILTIN_AI or STAND."""
    for i in range(match.num_players):
        match.players[i].action = actions[i]


@kernel
def num_agents(match):
    """Return A, the number of agents of both teams."""
    return match.num_agents[LEFT] + match.num_agents[RIGHT]


@kernel
def in_team_frame(team, action):
    """Rotate a direction, 1..8, for a right player, who sees the pitch from the other end; keep other actions."""
    if team == RIGHT and 1 <= action <= 8:
        return (action + 3) % 8 + 1
    return action


@kernel
def choose_controlled(match):
    """Give each agent the player that its next action moves."""
    first = 0
    for team in range(2):
        if match.control[team] == CLOSEST:
            choose_closest(match, team, first)
        elif match.control[team] == ACTIVE:
            choose_active(match, team, first)
        first += match.num_agents[team]


@kernel
def choose_closest(match, team, first):
    """Give the agents of a team, from `first` on, its players closest to the ball; ties are broken by program order."""
    for i in range(match.num_players):
        if match.players[i].team == team:
            match.players[i].agent = NOBODY
    for agent in range(first, first + match.num_agents[team]):
        best, closest = NOBODY, math.inf
        for i in range(match.num_players):
            player = match.players[i]
            if player.team != team or player.has_left or player.agent != NOBODY:
                continue
            dx, dy = match.ball.x - player.x, match.ball.y - player.y
            squared = dx * dx + dy * dy
            if squared < closest or (squared == closest and player.order < match.players[best].order):
                best, closest = i, squared
        match.agents[agent] = best
        if best != NOBODY:
            match.players[best].agent = agent
