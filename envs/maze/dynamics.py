"""A step of agents in mazes, as in MiniGrid (`MiniGridEnv.step`). Read next: `rollout`, whole rollouts; `env`."""

from __future__ import annotations

from regista.envs.maze.grid import DIRECTIONS, GOAL, LEFT, RIGHT, WALL
from regista.envs.maze.view import observe, stride
from regista.kernels.jit import kernel

TIME_COST = 0.9  # share of the reward that is lost when the goal is reached in the last step


@kernel
def begin(layouts, agents, e):
    """Put the agent of environment e at the start of its maze."""
    agents.at[e], agents.direction[e], agents.clock[e] = layouts.start[e], layouts.direction[e], 0


@kernel
def move(layouts, agents, settings, e, action):
    """Let the agent of environment e act; return whether it has moved onto the goal. Walls stop it."""
    agents.clock[e] += 1
    direction = agents.direction[e]
    if action == LEFT:
        agents.direction[e] = (direction + DIRECTIONS - 1) % DIRECTIONS
        return False
    if action == RIGHT:
        agents.direction[e] = (direction + 1) % DIRECTIONS
        return False
    ahead = agents.at[e] + stride(direction, settings.width)
    thing = layouts.grid[e, ahead]
    if thing != WALL:
        agents.at[e] = ahead
    return thing == GOAL


@kernel
def reward_of(arrived, clock, settings):
    """Return the reward of a step: 1 - 0.9 t / T at the goal after t steps (`MiniGridEnv._reward`), else 0."""
    return 1.0 - TIME_COST * (clock / settings.max_steps) if arrived else 0.0


@kernel
def is_late(agents, settings, e):
    """Return whether the time limit is reached; an agent that arrives in the last step is both late and at the goal."""
    return agents.clock[e] >= settings.max_steps


@kernel
def step_mazes(layouts, agents, settings, actions, outcome, vectors):
    """Step N mazes with actions `[N]`; write the outcome and the observations `[N, F]`."""
    for e in range(len(actions)):
        arrived = move(layouts, agents, settings, e, actions[e])
        outcome.terminated[e], outcome.truncated[e] = arrived, is_late(agents, settings, e)
        outcome.reward[e] = reward_of(arrived, agents.clock[e], settings)
        observe(layouts, agents, settings, e, vectors[e])
