"""Arguments of a simulator that plays whole rollouts in one kernel: plain records of arrays.

A rollout in Python calls the network and the environments once per step. For small networks and fast simulators these
calls take most of the time. `UPOMDP.play` takes a `CompiledRollout` instead and plays many steps in one call. It acts,
steps, records the results, and starts the next episodes on the levels passed to it. It returns when it needs another
level. `regista.kernels.rollout` has kernels for all of this except the step.

Letters: `T` steps, `N` environments, `A` agents, `F` features of an observation, `K` levels passed, `P` policies (1 or
A), `W` width of a memory. Read next: `learning.compiled`, which makes these records.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

LANES = 16  # rows that a network evaluates together
SCRATCH = 5  # arrays of intermediate results

# A layer: whether tanh follows it, whether it is the input layer of a GRU (the recurrent layer is next), the places in
# the weights where its matrix `[outputs, inputs]` and its bias begin, and its size.
LAYER = np.dtype(
    [("tanh", np.bool_), ("gru", np.bool_)] + [(name, np.int64) for name in ("matrix", "bias", "inputs", "outputs")]
)
# Progress of a kernel: the `step` of the rollout, the step `until` which it plays, the number of levels `taken` (at
# most `most`), the number of `events`, and the reason for an early stop: it `needs_level`, or an environment `failed`.
COUNTERS = np.dtype(
    [(name, np.int64) for name in ("step", "until", "taken", "most", "events")]
    + [("needs_level", np.bool_), ("failed", np.bool_)]
)


class Network(NamedTuple):
    """Weights and layers of a network, or of one network for each policy: `kernels.rollout.network` runs it.

    Without layers the critic is part of the actor, whose last output is then the value.
    """

    weights: np.ndarray  # [P, weights] float32
    layers: np.ndarray  # LAYER [L]


class Policy(NamedTuple):
    """A student: an actor, a critic, and the normalization of observations."""

    actor: Network
    critic: Network
    mean: np.ndarray  # [P, F] float32
    deviation: np.ndarray  # [P, F] float32
    limit: np.ndarray  # [1] float32, normalized observations are within ± this
    numbered: bool  # the actor, and the critic, also see which agent they are for
    central: bool  # the critic sees the observations of all agents
    actor_width: int  # of an agent's memory
    critic_width: int
    scratch: np.ndarray  # [SCRATCH, widest * LANES] float32
    state: np.ndarray  # [units of a GRU, or 1, * LANES] float32


class Steps(NamedTuple):
    """The columns of a `learning.rollout.Rollout`, as arrays with an axis of agents."""

    observation: np.ndarray  # [T, N, A, F] float32
    action: np.ndarray  # [T, N, A] int64
    log_prob: np.ndarray  # [T, N, A] float32
    value: np.ndarray  # [T, N, A] float32
    reward: np.ndarray  # [T, N, 1] float32, for opponents [T, N, A]
    terminated: np.ndarray  # [T, N] bool
    truncated: np.ndarray  # [T, N] bool
    final_value: np.ndarray  # [T, N, A] float32
    train: np.ndarray  # [T, N] bool
    uniform: np.ndarray  # [T, N, A] float32 in [0, 1), from which actions are sampled


class Envs(NamedTuple):
    """The mutable state of environments during a rollout."""

    observation: np.ndarray  # [N, A, F] float32, current; the simulator writes it
    action: np.ndarray  # [N, A] int64, of this step
    memory: np.ndarray  # [N, W] float32
    returns: np.ndarray  # [N] float64, of the open episodes
    lengths: np.ndarray  # [N] int64
    training: np.ndarray  # [N] bool, whether the student learns from the steps
    due: np.ndarray  # [N] int64, episodes left on the level; negative while it is repeated
    seed: np.ndarray  # [N] uint64, of the level
    visit: np.ndarray  # [N] int64
    episode: np.ndarray  # [N] int64
    ended: np.ndarray  # [N] bool, whether the episode ended in this step
    success: np.ndarray  # [N] float64, of the episodes that ended: 1, 0, nan if unknown
    restart: np.ndarray  # [N] bool, whether the next episode starts after this step
    start: np.ndarray  # [N] int64, the row of the prepared level that it starts on; negative: on the same level
    final_observation: np.ndarray  # [LANES, A, F] float32; this and the next three: of truncated episodes
    final_memory: np.ndarray  # [LANES, W] float32
    final_value: np.ndarray  # [LANES, A] float32
    final_env: np.ndarray  # [LANES] int64


class Levels(NamedTuple):
    """The levels passed to a kernel, in the order in which environments take them."""

    start: np.ndarray  # [K] int64, the row of the level that the simulator has prepared; negative: not prepared
    seed: np.ndarray  # [K] uint64
    visit: np.ndarray  # [K] int64
    num_episodes: np.ndarray  # [K] int64
    train: np.ndarray  # [K] bool


class Events(NamedTuple):
    """The episodes that ended, ordered by step, then by environment; E of T * N rows are used."""

    step: np.ndarray  # int64
    env: np.ndarray  # int64
    left: np.ndarray  # int64, episodes left on the level, including this episode
    returns: np.ndarray  # float64
    length: np.ndarray  # int64
    success: np.ndarray  # float64
    taken: np.ndarray  # int64, index of the level that the environment then took; -1: none


class CompiledRollout(NamedTuple):
    """All arguments of `UPOMDP.play`."""

    policy: Policy
    steps: Steps
    envs: Envs
    levels: Levels
    events: Events
    counters: np.ndarray  # COUNTERS [1]
