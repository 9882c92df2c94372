"""Actions, log-probabilities and values of a policy, `ued.core.compiled.Policy`, for N environments.

Blocks of 16 environments go through all layers, one agent after the other. Numbers are those of
`ued.learning.student.Student` up to rounding: log-probabilities differ by less than 1e-5.
Read next: `rollout.play`.
"""

from __future__ import annotations

import math

from regista.kernels.jit import kernel
from regista.kernels.rollout.lanes import LANES, exp_at
from regista.kernels.rollout.network import run_network


@kernel
def sample_actions(policy, steps, envs, t):
    """Fill `action`, `log_prob` and `value` of step t and `envs.action`; update the memory."""
    num_envs, agents = envs.action.shape
    shared = _is_shared(policy)
    outputs = policy.actor.layers[-1].outputs
    for first in range(0, num_envs, LANES):
        rows = min(LANES, num_envs - first)
        for agent in range(agents):
            logits = policy.scratch[_run_actor(policy, envs.observation, envs.memory, first, rows, agent)]
            if shared:
                _copy_lanes(logits, outputs - 1, steps.value[t], first, rows, agent)
            _choose(policy, logits, outputs - shared, steps, envs, t, first, rows, agent)
        if not shared:
            _run_critics(policy, envs.observation, envs.memory, first, rows, steps.value[t])


@kernel
def values_of(policy, observation, memory, rows, values):
    """Write the values of at most 16 `rows` of observations `[rows, A, F]` into `values` `[rows, A]`.

    `memory` is updated.
    """
    if not _is_shared(policy):
        _run_critics(policy, observation, memory, 0, rows, values)
        return
    for agent in range(observation.shape[1]):
        logits = policy.scratch[_run_actor(policy, observation, memory, 0, rows, agent)]
        _copy_lanes(logits, policy.actor.layers[-1].outputs - 1, values, 0, rows, agent)


@kernel
def _is_shared(policy):
    return len(policy.critic.layers) == 0


@kernel
def _copy_lanes(outputs, index, values, first, rows, agent):
    for r in range(rows):
        values[first + r, agent] = outputs[LANES * index + r]


@kernel
def _run_actor(policy, observation, memory, first, rows, agent):
    """Return which array of `scratch` holds the actor's outputs for a block of rows, `[outputs, 16]` flat.

    Its part of `memory` is updated.
    """
    p = agent if len(policy.actor.weights) > 1 else 0
    _write_inputs(policy, observation, first, rows, agent)
    width = policy.actor_width
    _read_memory(policy.state, memory, first, rows, width * agent, width)
    at = run_network(policy.actor.weights[p], policy.actor.layers, policy.state, policy.scratch)
    _write_memory(policy.state, memory, first, rows, width * agent, width)
    return at


@kernel
def _run_critics(policy, observation, memory, first, rows, values):
    """Write the values of a block of rows; update the critics' part of `memory`."""
    agents, width = observation.shape[1], policy.critic_width
    for agent in range(1 if policy.central else agents):
        p = agent if len(policy.critic.weights) > 1 else 0
        if policy.central:
            _write_all_inputs(policy, observation, first, rows)
        else:
            _write_inputs(policy, observation, first, rows, agent)
        begin = policy.actor_width * agents + width * agent
        _read_memory(policy.state, memory, first, rows, begin, width)
        at = run_network(policy.critic.weights[p], policy.critic.layers, policy.state, policy.scratch)
        _write_memory(policy.state, memory, first, rows, begin, width)
        _copy_lanes(policy.scratch[at], 0, values, first, rows, agent)
    if policy.central:
        for r in range(rows):
            values[first + r, :] = values[first + r, 0]


@kernel
def _write_inputs(policy, observation, first, rows, agent):
    """Write an agent's normalized observations into the first array of `scratch`, and which agent it is."""
    x, features = policy.scratch[0], observation.shape[2]
    _normalize(policy, observation, first, rows, agent, 0)
    if policy.numbered:
        for b in range(observation.shape[1]):
            for r in range(rows):
                x[LANES * (features + b) + r] = 1.0 if b == agent else 0.0


@kernel
def _write_all_inputs(policy, observation, first, rows):
    for agent in range(observation.shape[1]):
        _normalize(policy, observation, first, rows, agent, observation.shape[2] * agent)


@kernel
def _normalize(policy, observation, first, rows, agent, at):
    x, p = policy.scratch[0], agent if len(policy.mean) > 1 else 0
    mean, deviation, limit = policy.mean[p], policy.deviation[p], policy.limit[0]
    for r in range(rows):
        row = observation[first + r, agent]
        for f in range(len(row)):
            entry = (row[f] - mean[f]) / deviation[f]
            x[LANES * (at + f) + r] = limit if entry > limit else -limit if entry < -limit else entry  # nan stays


@kernel
def _read_memory(state, memory, first, rows, begin, width):
    for r in range(rows):
        for i in range(width):
            state[LANES * i + r] = memory[first + r, begin + i]


@kernel
def _write_memory(state, memory, first, rows, begin, width):
    for r in range(rows):
        for i in range(width):
            memory[first + r, begin + i] = state[LANES * i + r]


@kernel
def _choose(policy, logits, actions, steps, envs, t, first, rows, agent):
    """Sample an action of each row by the inverse of its cumulative distribution (see `networks.Categorical`)."""
    odds = policy.scratch[3]
    for r in range(rows):
        largest = logits[r]
        for k in range(1, actions):
            largest = max(largest, logits[LANES * k + r])
        policy.state[r] = largest
    for k in range(actions):
        for r in range(LANES):
            odds[LANES * k + r] = logits[LANES * k + r] - policy.state[r]
        exp_at(odds, LANES * k)
    for r in range(rows):
        total = 0.0
        for k in range(actions):
            total += odds[LANES * k + r]
        threshold, below, chosen = steps.uniform[t, first + r, agent] * total, 0.0, 0
        for k in range(actions - 1):
            below += odds[LANES * k + r]
            if below < threshold:
                chosen = k + 1
        envs.action[first + r, agent] = chosen
        steps.action[t, first + r, agent] = chosen
        steps.log_prob[t, first + r, agent] = logits[LANES * chosen + r] - policy.state[r] - math.log(total)
