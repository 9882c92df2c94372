"""Built-in players whose team has the ball and who have not: come free, keep apart, run, and stay onside.

As documented of Google Research Football: a place between the slot and one where a field of forces leads, and now
and then a run behind the defence. Read next: `ai.attack`, for the player on the ball.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from envs.football.ai.formation import formation_place, on_pitch
from envs.football.ai.run_speed import head_for
from envs.football.constants import GK, HALF_LENGTH, LEFT, NOBODY, RIGHT
from envs.football.physics.pitch import forward
from envs.football.physics.vectors import apart, length
from envs.football.rules.offside import second_last
from scenic_lite.kernels.jit import kernel


class Support(NamedTuple):
    """A place for who has not the ball, between his slot and where a field of forces leads."""

    least: float = 0.1  # share of the forces, far from the ball
    most: float = 0.9  # and near it
    near: float = 12.0  # m
    far: float = 40.0  # m
    mates_apart: float = 10.0  # m
    mates_push: float = 0.5  # m per m
    shadow: float = 5.0  # m to either side of the line behind an opponent
    shadow_push: float = 0.8  # m per m
    come_within: float = 7.0  # m to the ball
    come: float = 0.6  # m per m
    keep_off: float = 2.0  # m to the ball
    forward_slot: float = 0.2  # slots from here on push forward,
    lane_run: float = 6.0  # m
    onside: float = -1.8  # m: he misjudges the line by this much


class Run(NamedTuple):
    """Runs behind the defence."""

    ahead: float = 16.0  # m
    within: float = 40.0  # m ahead of the ball at most
    clear: float = 3.0  # m between a runner and any opponent
    slot: float = -0.2  # slots further back do not run


# Documented of Google Research Football; forces and runs are fitted: `regista benchmark --suite grf`, family matches.
SUPPORT, RUN = Support(), Run()
DECIDED_EVERY = 3  # steps; who decides when is staggered by shirts
RUN_STEPS = 40  # steps of a run
RUNS_EVERY = 5  # steps between two calls of `start_runs`


@kernel
def support(match, i):
    """Head for the place that was chosen last, choosing anew every few steps."""
    player = match.players[i]
    if (match.step + player.shirt) % DECIDED_EVERY == 0:
        choose_place(match, i)
    head_for(match, player, player.support_x, player.support_y)


@kernel
def choose_place(match, i):
    """Set where player i supports the player on the ball."""
    player = match.players[i]
    if match.runner[player.team] == i:
        x, y = player.x + forward(player.team) * RUN.ahead, 0.9 * player.y
    else:
        x, y = formation_place(match, player)
        near = (length(match.ball.x - x, match.ball.y - y) - SUPPORT.near) / (SUPPORT.far - SUPPORT.near)
        weight = SUPPORT.most + (SUPPORT.least - SUPPORT.most) * min(max(near, 0.0), 1.0)
        force_x, force_y = support_force(match, i, x, y)
        x, y = x + weight * force_x, y + weight * force_y
    x, y = on_pitch(x, y)
    ahead = forward(player.team)
    player.support_x, player.support_y = ahead * min(ahead * x, onside_line(match, player.team) - SUPPORT.onside), y


@kernel
def support_force(match, i, x, y):
    """Return the way in m that leads from (x, y) to a better place for player i: apart from mates, out of shadows."""
    player, ball = match.players[i], match.ball
    to_x, to_y = x - ball.x, y - ball.y
    distance = math.sqrt(to_x * to_x + to_y * to_y) + 1e-9
    ux, uy = to_x / distance, to_y / distance
    force_x = forward(player.team) * SUPPORT.lane_run if player.slot_x > SUPPORT.forward_slot else 0.0
    force_y = 0.0
    reach = max(SUPPORT.keep_off - distance, 0.0) - SUPPORT.come * max(distance - SUPPORT.come_within, 0.0)
    force_x += reach * ux
    force_y += reach * uy
    for j in range(match.num_players):
        other = match.players[j]
        if j == i:
            continue
        if other.team == player.team:
            dx, dy = x - other.x, y - other.y
            squared = dx * dx + dy * dy
            if 0.0 < squared < SUPPORT.mates_apart * SUPPORT.mates_apart:
                away = math.sqrt(squared)
                push = SUPPORT.mates_push * (SUPPORT.mates_apart - away) / away
                force_x += push * dx
                force_y += push * dy
            continue
        dx, dy = other.x - ball.x, other.y - ball.y
        along, across = dx * ux + dy * uy, dx * uy - dy * ux
        if 0.0 < along < distance + SUPPORT.shadow and 0.0 < abs(across) < SUPPORT.shadow:
            push = math.copysign(SUPPORT.shadow_push * (SUPPORT.shadow - abs(across)), across)
            force_x -= push * uy
            force_y += push * ux
    return force_x, force_y


@kernel
def onside_line(match, team):
    """Return how far forward in m a player of `team` may stand."""
    ahead = forward(team)
    return max(second_last(match, 1 - team, ahead), ahead * match.ball.x, 0.0)


@kernel
def start_runs(match):
    """Let time pass for runs, and let the team on the ball start one if nobody runs."""
    for team in (LEFT, RIGHT):
        match.run_steps_left[team] -= RUNS_EVERY
        if match.team_in_possession != team or match.run_steps_left[team] <= 0:
            match.runner[team] = NOBODY
        if match.team_in_possession == team and match.runner[team] == NOBODY and match.carrier != NOBODY:
            match.runner[team] = free_runner(match, team)
            match.run_steps_left[team] = RUN_STEPS


@kernel
def free_runner(match, team):
    """Return the foremost mate of the player on the ball who is onside and free, -1 none."""
    ahead = forward(team)
    line = onside_line(match, team)
    best, most = NOBODY, 0.0
    for i in range(match.num_players):
        player = match.players[i]
        if player.team != team or player.role == GK or i == match.carrier or player.slot_x < RUN.slot:
            continue
        lead = ahead * (player.x - match.ball.x)
        if not most < lead < RUN.within or ahead * player.x > line or ahead * player.x > HALF_LENGTH - RUN.ahead:
            continue
        if clear_of_opponents(match, player, RUN.clear):
            best, most = i, lead
    return best


@kernel
def clear_of_opponents(match, player, distance):
    """Return whether no opponent is this close to a player."""
    for j in range(match.num_players):
        if match.players[j].team != player.team and apart(match.players[j], player) < distance:
            return False
    return True
