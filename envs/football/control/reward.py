"""The reward of a step: goals, checkpoints on the way to the opponents' goal, the program's rewards.

Read next: `batch`.
"""

from __future__ import annotations

from regista.envs.football.constants import LEFT, METRES_PER_X, METRES_PER_Y, NOBODY
from regista.envs.football.control.agents import num_agents
from regista.envs.football.physics.vectors import length
from regista.kernels.jit import kernel

CHECKPOINTS, CHECKPOINT_REWARD = 10, 0.1
FIRST_CHECKPOINT, CHECKPOINT_SPAN = 0.99, 0.8  # units of Google Research Football to (1, 0)
UNIT_X, UNIT_Y = 100 * METRES_PER_X, 100 * METRES_PER_Y  # m per unit


@kernel
def clear_rewards(match):
    """Clear the rewards of the last step."""
    match.checkpoint_reward[:] = 0.0
    match.program_reward = 0.0


@kernel
def agent_reward(match, agent, checkpoints):
    """Return an agent's reward for the last step: +1 or -1 for a goal and, with `checkpoints`, 0.1 for each new
    checkpoint.

    The `scenic_reward` of the program's monitors is added.
    """
    total = side(match, agent) * match.goal + match.program_reward
    return total + match.checkpoint_reward[agent] if checkpoints else total


@kernel
def team_reward(match, checkpoints):
    """Return the mean reward of the left team's agents, or of the right team's if the left team has no agents."""
    first, last = 0, match.num_agents[LEFT]
    if last == 0:
        last = num_agents(match)
    if last == 0:
        return match.goal + match.program_reward
    total = 0.0
    for agent in range(first, last):
        total += agent_reward(match, agent, checkpoints)
    return total / last


@kernel
def side(match, agent):
    """Return 1 for an agent of the left team, -1 for one of the right team."""
    return 1.0 if agent < match.num_agents[LEFT] else -1.0


@kernel
def add_checkpoint_rewards(match):
    """Reward each agent once for each checkpoint while its player owns the ball, and for the remaining ones at a goal.

    As in Google Research Football's wrapper, the player that the agent has after the step must own the ball.
    """
    for agent in range(num_agents(match)):
        reached, forward = match.checkpoints[agent], side(match, agent)
        if match.goal * forward > 0.0:
            reached = CHECKPOINTS
        elif match.reported_owner != NOBODY and match.reported_owner == match.agents[agent]:
            distance = length(forward * match.ball.x / UNIT_X - 1.0, match.ball.y / UNIT_Y)
            while reached < CHECKPOINTS and distance <= threshold(reached):
                reached += 1
        match.checkpoint_reward[agent] = CHECKPOINT_REWARD * (reached - match.checkpoints[agent])
        match.checkpoints[agent] = reached


@kernel
def threshold(reached):
    """Return the distance to the goal of the next checkpoint, after `reached` checkpoints."""
    return FIRST_CHECKPOINT - reached * CHECKPOINT_SPAN / (CHECKPOINTS - 1)
