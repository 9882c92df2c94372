"""Whole rollouts of mazes in one kernel: policy, steps and new episodes without a return to Python.

Read next: `kernels.rollout.play`.
"""

from __future__ import annotations

from regista.envs.maze.dynamics import begin, is_late, move, reward_of
from regista.envs.maze.view import observe
from regista.kernels.jit import kernel
from regista.kernels.rollout.play import act, choose_levels, copy, note


@kernel
def play_mazes(rollout, layouts, agents, pool, settings):
    """Play mazes until the rollout is full or a level is needed; `pool` are the Layouts of the prepared levels."""
    envs = rollout.envs
    while act(rollout):
        for e in range(len(envs.action)):
            arrived = move(layouts, agents, settings, e, envs.action[e, 0])
            reward, success = reward_of(arrived, agents.clock[e], settings), 1.0 if arrived else 0.0
            note(rollout, e, reward, arrived, is_late(agents, settings, e), success)
            observe(layouts, agents, settings, e, envs.observation[e, 0])
        if not choose_levels(rollout):
            return
        for e in range(len(envs.action)):
            if envs.restart[e]:
                start(layouts, agents, pool, envs.start[e], e)
                observe(layouts, agents, settings, e, envs.observation[e, 0])


@kernel
def start(layouts, agents, pool, row, e):
    """Start the next episode of environment e; if `row` is not negative, in the maze of this row of the pool."""
    if row >= 0:
        copy(pool.grid[row], layouts.grid[e])
        layouts.start[e], layouts.direction[e] = pool.start[row], pool.direction[row]
    begin(layouts, agents, e)
