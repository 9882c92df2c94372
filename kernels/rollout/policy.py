"""Actions, log-probabilities and values of a policy, `ued.core.compiled.Policy`, for N environments.

Blocks of 16 environments pass through all layers, agent by agent. Results equal those of
`ued.learning.student.Student` up to rounding: log-probabilities differ by less than 1e-5.
Read next: `rollout.play`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.kernels.jit import kernel
from regista.kernels.rollout.lanes import LANES, exp_at
from regista.kernels.rollout.network import run_network


class Block(NamedTuple):
    """Rows of an array that are evaluated together for one agent: `rows`, at most 16, starting at `first`."""

    first: int
    rows: int
    agent: int


@kernel
def sample_actions(policy, steps, envs, t):
    """Fill `action`, `log_prob` and `value` of step t and `envs.action`; update the memory."""
    num_envs, agents = envs.action.shape
    shared = _is_shared(policy)
    for first in range(0, num_envs, LANES):
        rows = min(LANES, num_envs - first)
        for agent in range(agents):
            block = Block(first, rows, agent)
            logits = policy.scratch[_run_actor(policy, envs.observation, envs.memory, block)]
            if shared:
                _copy_value(logits, policy.actor.layers[-1].outputs - 1, steps.value[t], block)
            _choose(policy, logits, steps, envs, t, block)
        if not shared:
            _run_critics(policy, envs.observation, envs.memory, Block(first, rows, 0), steps.value[t])


@kernel
def values_of(policy, observation, memory, rows, values):
    """Write the values of at most 16 `rows` of observations `[rows, A, F]` into `values` `[rows, A]`.

    `memory` is updated.
    """
    if not _is_shared(policy):
        _run_critics(policy, observation, memory, Block(0, rows, 0), values)
        return
    for agent in range(observation.shape[1]):
        block = Block(0, rows, agent)
        outputs = policy.scratch[_run_actor(policy, observation, memory, block)]
        _copy_value(outputs, policy.actor.layers[-1].outputs - 1, values, block)


@kernel
def _is_shared(policy):
    """Return whether the value is the last output of the actor."""
    return len(policy.critic.layers) == 0


@kernel
def _copy_value(outputs, index, values, block):
    for r in range(block.rows):
        values[block.first + r, block.agent] = outputs[LANES * index + r]


@kernel
def _run_actor(policy, observation, memory, block):
    """Run the actor and update its part of `memory`.

    Return the index of the array in `scratch` that holds the outputs, `[outputs, 16]` flat.
    """
    p = block.agent if len(policy.actor.weights) > 1 else 0
    begin, width = policy.actor_width * block.agent, policy.actor_width
    _write_inputs(policy, observation, block)
    _read_memory(policy.state, memory, block, begin, width)
    at = run_network(policy.actor.weights[p], policy.actor.layers, policy.state, policy.scratch)
    _write_memory(policy.state, memory, block, begin, width)
    return at


@kernel
def _run_critics(policy, observation, memory, block, values):
    """Write the values of all agents for the rows of a block; update the critics' part of `memory`."""
    agents, width = observation.shape[1], policy.critic_width
    for agent in range(1 if policy.central else agents):
        one, p = Block(block.first, block.rows, agent), agent if len(policy.critic.weights) > 1 else 0
        if policy.central:
            _write_all_inputs(policy, observation, one)
        else:
            _write_inputs(policy, observation, one)
        begin = policy.actor_width * agents + width * agent
        _read_memory(policy.state, memory, one, begin, width)
        at = run_network(policy.critic.weights[p], policy.critic.layers, policy.state, policy.scratch)
        _write_memory(policy.state, memory, one, begin, width)
        _copy_value(policy.scratch[at], 0, values, one)
    if policy.central:
        for r in range(block.first, block.first + block.rows):
            values[r, :] = values[r, 0]


@kernel
def _write_inputs(policy, observation, block):
    """Write an agent's normalized observations and its one-hot index into the first array of `scratch`."""
    x, features = policy.scratch[0], observation.shape[2]
    _normalize(policy, observation, block, 0)
    if policy.numbered:
        for agent in range(observation.shape[1]):
            for r in range(block.rows):
                x[LANES * (features + agent) + r] = 1.0 if agent == block.agent else 0.0


@kernel
def _write_all_inputs(policy, observation, block):
    for agent in range(observation.shape[1]):
        _normalize(policy, observation, Block(block.first, block.rows, agent), observation.shape[2] * agent)


@kernel
def _normalize(policy, observation, block, at):
    """Write the observations of a block as features `at`, `at` + 1 ... of the first array of `scratch`."""
    x, p = policy.scratch[0], block.agent if len(policy.mean) > 1 else 0
    mean, deviation, limit = policy.mean[p], policy.deviation[p], policy.limit[0]
    for r in range(block.rows):
        row = observation[block.first + r, block.agent]
        for f in range(len(row)):
            entry = (row[f] - mean[f]) / deviation[f]
            x[LANES * (at + f) + r] = limit if entry > limit else -limit if entry < -limit else entry  # nan is kept


@kernel
def _read_memory(state, memory, block, begin, width):
    for r in range(block.rows):
        for i in range(width):
            state[LANES * i + r] = memory[block.first + r, begin + i]


@kernel
def _write_memory(state, memory, block, begin, width):
    for r in range(block.rows):
        for i in range(width):
            memory[block.first + r, begin + i] = state[LANES * i + r]


@kernel
def _choose(policy, logits, steps, envs, t, block):
    """Sample an action of each row by the inverse of its cumulative distribution (see `networks.Categorical`)."""
    actions = policy.actor.layers[-1].outputs - _is_shared(policy)
    odds, largest = policy.scratch[3], policy.state
    for r in range(LANES):
        largest[r] = logits[r]
        for k in range(1, actions):
            largest[r] = max(largest[r], logits[LANES * k + r])
    for k in range(actions):
        for r in range(LANES):
            odds[LANES * k + r] = logits[LANES * k + r] - largest[r]
        exp_at(odds, LANES * k)
    for r in range(block.rows):
        total = 0.0
        for k in range(actions):
            total += odds[LANES * k + r]
        e = block.first + r
        threshold, below, chosen = steps.uniform[t, e, block.agent] * total, 0.0, 0
        for k in range(actions - 1):
            below += odds[LANES * k + r]
            if below < threshold:
                chosen = k + 1
        envs.action[e, block.agent] = steps.action[t, e, block.agent] = chosen
        steps.log_prob[t, e, block.agent] = logits[LANES * chosen + r] - largest[r] - math.log(total)
