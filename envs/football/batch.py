"""The batch loop: N matches, each stepped, rewarded, observed, and started again when it has ended.

This is the only loop over matches, and the only parallel one; all that it calls is scalar code on one match. A match
never reads another, so the result is the same for any number of threads. Read next: `simulator`, for one step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from envs.football.observation import write_features
from envs.football.reward import reward
from envs.football.simulator import step_match
from envs.football.state import MATCH
from scenic_lite.jit import kernel


class Outcome(NamedTuple):
    """What a step brought, one row per match; written by `step_batch`, read by the environment."""

    observations: np.ndarray  # [N, F] float32, of the new episode where one ended
    final_observations: np.ndarray  # [N, F] float32, the last of an ended episode
    rewards: np.ndarray  # [N] float64
    terminated: np.ndarray  # [N] bool
    truncated: np.ndarray  # [N] bool
    ended: np.ndarray  # [N] int64, `constants.RUNNING` .. `DURATION`
    faults: np.ndarray  # [N] int64


class Rules(NamedTuple):
    """How rewards and restarts work, the same for all matches."""

    checkpoints: bool  # checkpoints count
    deterministic: bool  # every episode repeats the same stream of random numbers
    restart: bool  # an ended match starts again at once; if not, the caller sees to it


def empty_matches(count: int) -> np.ndarray:
    """Room for `count` matches: MATCH `[count]`, as records whose fields are attributes even when not compiled."""
    return np.zeros(count, MATCH).view(np.recarray)


def empty_outcome(count: int, size: int) -> Outcome:
    """Room for what `count` matches bring, with observations of `size` entries."""
    return Outcome(
        np.zeros((count, size), np.float32),
        np.zeros((count, size), np.float32),
        np.zeros(count),
        np.zeros(count, bool),
        np.zeros(count, bool),
        np.zeros(count, np.int64),
        np.zeros(count, np.int64),
    )


@kernel(parallel=True)
def step_batch(matches, starts, actions, outcome, rules):
    """Step MATCH `[N]` with actions `[N]`; an ended match starts again from its row of `starts` `[N]`."""
    for index in prange(len(matches)):
        # One call: Numba's parallel pass reorders the statements of a loop body, and does not see that they share
        # the record.
        _step_row(matches, starts, actions, outcome, rules, index)


@kernel
def _step_row(matches, starts, actions, outcome, rules, index):
    """Step, reward, observe and if need be restart one match."""
    match = matches[index]
    step_match(match, actions[index])
    outcome.rewards[index] = reward(match, rules.checkpoints)
    outcome.terminated[index] = match.terminated
    outcome.truncated[index] = match.truncated
    outcome.ended[index] = match.ended
    outcome.faults[index] = match.fault
    if match.terminated or match.truncated:
        write_features(match, outcome.final_observations[index])
        if rules.restart:
            _restart(matches, starts, index, rules.deterministic)
    write_features(matches[index], outcome.observations[index])


@kernel
def _restart(matches, starts, index, deterministic):
    """Start the next episode on the same level; its random stream goes on where the last one stopped."""
    stream = matches[index].random
    matches[index] = starts[index]
    if not deterministic:
        matches[index].random = stream


@kernel
def observe_batch(matches, where, observations):
    """Write the observations `[N, F]` of the matches `where` (indices `[k]`)."""
    for index in where:
        write_features(matches[index], observations[index])
