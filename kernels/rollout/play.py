"""The functions that a simulator's kernel calls to collect rollouts; see `docs/howto/simulator.md`.

    while act(rollout):
        for e in range(len(rollout.envs.action)):
            ...                                     # step environment e with envs.action[e]
            note(rollout, e, reward, terminated, truncated, success)
            ...                                     # write its observation
        if not choose_levels(rollout):
            break
        for e in range(len(rollout.envs.action)):
            ...                                     # start an episode where envs.restart[e]

`rollout` is a `ued.core.compiled.CompiledRollout`. Levels follow the order of `ued.levels.queue.LevelQueue`.
"""

from __future__ import annotations

import numpy as np

from regista.kernels.jit import kernel
from regista.kernels.rollout.lanes import LANES
from regista.kernels.rollout.policy import sample_actions, values_of


@kernel
def copy(source, target):
    """Copy the entries of a vector; a NumPy assignment would allocate a temporary copy."""
    for i in range(len(source)):
        target[i] = source[i]


@kernel
def copy_rows(source, target):
    """Copy the entries of a matrix."""
    for row in range(len(source)):
        copy(source[row], target[row])


@kernel
def act(rollout):
    """Begin a step: record the observations and sample `envs.action`. Return False after the last step."""
    counters, steps, envs = rollout.counters[0], rollout.steps, rollout.envs
    if counters.step >= counters.until:
        return False
    for e in range(len(envs.action)):
        copy_rows(envs.observation[e], steps.observation[counters.step, e])
        steps.train[counters.step, e] = envs.training[e]
    sample_actions(rollout.policy, steps, envs, counters.step)
    return True


@kernel
def note(rollout, e, reward, terminated, truncated, success):
    """Record the results of a step of environment `e`.

    `success` is 1, 0 or nan (unknown) at the end of an episode. With opponents, the caller also writes the rewards of
    all agents into `steps.reward[t, e]`, and `reward` is the reward of the first side.
    """
    steps, envs, t = rollout.steps, rollout.envs, rollout.counters[0].step
    if steps.reward.shape[2] == 1:
        steps.reward[t, e, 0] = reward
    steps.terminated[t, e], steps.truncated[t, e] = terminated, truncated
    steps.final_value[t, e, :] = 0.0
    envs.returns[e] += reward
    envs.lengths[e] += 1
    envs.ended[e] = terminated or truncated
    envs.success[e] = success


@kernel
def choose_levels(rollout):
    """End a step: evaluate the final observations of truncated episodes, and choose the levels of new episodes.

    Return False if a required level is not prepared: the trainer then ends the episodes of this step.
    """
    counters, envs, ended = rollout.counters[0], rollout.envs, 0
    for e in range(len(envs.action)):
        envs.restart[e] = False
        ended += envs.ended[e]
    if ended:
        _value_final_observations(rollout)
        if not _are_at_hand(rollout):
            counters.needs_level = True
            return False
        first = counters.events
        _end_episodes(rollout)
        _take_levels(rollout, first, True)
        _take_levels(rollout, first, False)
    counters.step += 1
    return True


@kernel
def _value_final_observations(rollout):
    """Store the values of the final observations of truncated episodes, block by block."""
    steps, envs, t, rows = rollout.steps, rollout.envs, rollout.counters[0].step, 0
    for e in range(len(envs.action)):
        if steps.truncated[t, e] and not steps.terminated[t, e]:
            envs.final_env[rows] = e
            copy_rows(envs.observation[e], envs.final_observation[rows])
            copy(envs.memory[e], envs.final_memory[rows])
            rows += 1
        if rows == LANES or (rows and e == len(envs.action) - 1):
            values_of(rollout.policy, envs.final_observation, envs.final_memory, rows, envs.final_value)
            for row in range(rows):
                copy(envs.final_value[row], steps.final_value[t, envs.final_env[row]])
            rows = 0


@kernel
def _are_at_hand(rollout):
    """Return whether the levels that environments take after this step are prepared."""
    counters, envs, levels = rollout.counters[0], rollout.envs, rollout.levels
    after = counters.taken
    for e in range(len(envs.action)):
        if envs.ended[e] and envs.due[e] <= 1:
            after += 1
    for level in range(counters.taken, min(after, counters.most)):
        if level >= len(levels.start) or levels.start[level] < 0:
            return False
    return True


@kernel
def _end_episodes(rollout):
    """Log the episodes that ended. Each environment restarts its level, unless `_take_levels` replaces it."""
    counters, envs, events = rollout.counters[0], rollout.envs, rollout.events
    for e in range(len(envs.action)):
        if not envs.ended[e]:
            continue
        k = counters.events
        events.step[k], events.env[k], events.left[k] = counters.step, e, envs.due[e]
        events.returns[k], events.length[k], events.success[k] = envs.returns[e], envs.lengths[e], envs.success[e]
        events.taken[k] = -1
        counters.events += 1
        envs.returns[e], envs.lengths[e] = 0.0, 0
        envs.memory[e, :] = 0.0
        envs.due[e] -= 1
        envs.episode[e] += 1
        envs.restart[e], envs.start[e] = True, -1


@kernel
def _take_levels(rollout, first, repeating):
    """Assign the next levels to environments that finished theirs; those that were `repeating` come first."""
    counters, envs, levels, events = rollout.counters[0], rollout.envs, rollout.levels, rollout.events
    for k in range(first, counters.events):
        e, level = events.env[k], counters.taken
        if level >= counters.most or (envs.due[e] >= 0 if repeating else envs.due[e] != 0):
            continue
        events.taken[k] = level
        envs.start[e], envs.seed[e], envs.visit[e] = levels.start[level], levels.seed[level], levels.visit[level]
        envs.episode[e], envs.due[e] = 0, levels.num_episodes[level]
        envs.training[e] = levels.train[level]
        counters.taken += 1


_VISIT, _EPISODE = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xD1342543DE82EF95)
_FIRST_FACTOR, _SECOND_FACTOR = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_30, _27, _31, _MASK = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(2**31 - 1)


@kernel
def luck_seed(rollout, e, seed_is_luck):
    """Return the luck seed (uint64, as in `UPOMDP.luck_seeds`) of the episode that starts in environment `e`."""
    envs = rollout.envs
    episode = envs.episode[e] + (0 if seed_is_luck else 1)
    state = np.uint64(envs.visit[e]) * _VISIT + np.uint64(episode) * _EPISODE
    state = (state ^ (state >> _30)) * _FIRST_FACTOR
    state = (state ^ (state >> _27)) * _SECOND_FACTOR
    return envs.seed[e] ^ ((state ^ (state >> _31)) & _MASK)
