"""Built-in players on the ball: shoot, pass, dribble along a field of forces, or play a free ball first-time.

The order of decisions and the forces are documented by Google Research Football. Read next: `ai.shooting`,
`ai.passing`; `ai.support`, for their teammates.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.ai.passing import consider_first_time_pass, consider_pass
from regista.envs.football.ai.run_speed import GAIT_CHOICE
from regista.envs.football.ai.shooting import consider_shot
from regista.envs.football.constants import DRIBBLE_SPEED, GOAL_HALF_WIDTH, HALF_LENGTH, HALF_WIDTH, NOBODY, RUN_SPEED
from regista.envs.football.physics.dribble import TOUCH
from regista.envs.football.physics.pitch import attacked_goal_x
from regista.envs.football.physics.possession import forget_kick
from regista.envs.football.physics.vectors import apart, length
from regista.envs.football.skills.steering import chase
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Forces(NamedTuple):
    """The forces on a dribbler, relative to the goal's pull of 1."""

    centre_pull: float = 0.72  # share of the lateral way to the middle of the goal in the pull; the rest keeps the lane
    rivals_range: float = 10.0  # m
    rivals_push: float = 2.6  # force of an opponent at distance 0
    rivals_most: float = 1.0  # maximum force of all opponents together
    lines_range: float = 20.0  # m
    lines_push: float = 4.0
    beside_goal: float = 12.0  # m beside the goal, beyond which its line pushes in full
    speed: float = 8.0  # m/s for a force of 1


class FreeBall(NamedTuple):
    """Playing a free ball first-time."""

    at_once: float = 0.25  # s before the contact, from which on the player decides on a first-time kick
    volley_fits: float = 0.3  # chance per step that the stride allows a shot


# Documented by Google Research Football, except `rivals_push`, `lines_push` and `rivals_most`, which are fitted;
# checked by `lab.benchmarks --suite grf`, families matches and academy.
FORCES, FREE_BALL = Forces(), FreeBall()


@kernel
def play_ball(match, i):
    """Decide for the carrier: shoot, pass, or dribble."""
    player = match.players[i]
    if match.kicker == i:
        return
    if player.kick == 0 and kicks_himself(match, player) and not consider_shot(match, i):
        consider_pass(match, i)
    if apart(match.ball, player) > TOUCH.reach:
        chase(match, i, player.top_speed)
    else:
        run_by_forces(match, player)


@kernel
def meet_free_ball(match, i):
    """Run for a free ball as the first player of the team; just before the contact, decide on a first-time kick.

    In GRF's matches, 40% of the shots and 20% of the passes are first-time kicks.
    """
    player = match.players[i]
    chase(match, i, player.top_speed)
    if not kicks_himself(match, player):
        return
    forget_kick(player)
    if match.arrival[player.team] > FREE_BALL.at_once:
        return
    if uniform(match) > FREE_BALL.volley_fits or not consider_shot(match, i):
        consider_first_time_pass(match, i)


@kernel
def kicks_himself(match, player):
    """Return whether a player may kick. In a team with agents, only players left to the built-in AI may."""
    return match.num_agents[player.team] == 0 or player.agent != NOBODY


@kernel
def run_by_forces(match, player):
    """Dribble along the sum of the forces of goal, opponents and lines, at the gait that fits the force."""
    force_x, force_y = pull_of_goal(player)
    push_x, push_y = push_of_rivals(match, player)
    force_x += push_x + push_of_goal_line(player)
    force_y += push_y + push_of_line(HALF_WIDTH, player.y)
    size = length(force_x, force_y) + 1e-9
    speed = carrying_speed(player, FORCES.speed * size)
    player.desired_vx, player.desired_vy = force_x / size * speed, force_y / size * speed


@kernel
def carrying_speed(player, desired):
    """Return the speed in m/s with the ball for a desired speed; a dribbler never stops."""
    if desired < GAIT_CHOICE.walks:
        return DRIBBLE_SPEED
    return RUN_SPEED if desired < GAIT_CHOICE.runs else player.top_speed


@kernel
def pull_of_goal(player):
    """Return a force of 1 towards a point between the middle of the goal and the player's own lane."""
    to_x, to_y = attacked_goal_x(player.team) - player.x, -FORCES.centre_pull * player.y
    distance = length(to_x, to_y) + 1e-9
    return to_x / distance, to_y / distance


@kernel
def push_of_rivals(match, player):
    """Return the force away from nearby opponents.

    The push of an opponent is fitted to scenes with one or two opponents. The sum over a whole team would exceed the
    pull of the goal, and no dribbler would come near the goal. So the sum is limited to the pull of the goal. A single
    opponent nearer than 6.2 m also reaches the limit. If this opponent is straight ahead, the forces cancel, and the
    dribbler moves sideways.
    """
    force_x, force_y = 0.0, 0.0
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == player.team:
            continue
        dx, dy = player.x - rival.x, player.y - rival.y
        squared = dx * dx + dy * dy
        if 0.0 < squared < FORCES.rivals_range * FORCES.rivals_range:
            distance = math.sqrt(squared)
            push = FORCES.rivals_push * (1.0 - distance / FORCES.rivals_range) / distance
            force_x += push * dx
            force_y += push * dy
    capped = min(FORCES.rivals_most / (length(force_x, force_y) + 1e-9), 1.0)
    return capped * force_x, capped * force_y


@kernel
def push_of_goal_line(player):
    """Return the force away from the goal lines, except in front of the goal."""
    beside = min(max((abs(player.y) - GOAL_HALF_WIDTH) / FORCES.beside_goal, 0.0), 1.0)
    return beside * push_of_line(HALF_LENGTH, player.x)


@kernel
def push_of_line(limit, place):
    """Return the force away from the nearer of two lines at -limit and limit."""
    near = max(1.0 - (limit - abs(place)) / FORCES.lines_range, 0.0)
    return -math.copysign(FORCES.lines_push * near * near, place)
