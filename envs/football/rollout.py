"""Whole rollouts of matches in one kernel: policy, steps and new episodes without a return to Python.

Matches are stepped by the same kernels as in `batch`, so the results are the same. Read next: `kernels.rollout.play`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.batch import Batch, BatchSettings, Pool, begin_match, begin_row, finish_row, run_monitors
from regista.envs.football.constants import NO_FAULT
from regista.envs.football.observation.observe import observe
from regista.envs.football.simulator import play
from regista.kernels.jit import kernel
from regista.kernels.rng import start_of
from regista.kernels.rollout.play import act, choose_levels, copy, luck_seed, note
from scenic_lite.dynamics.machine.bytecode import Code


class Matches(NamedTuple):
    """The matches of a rollout, the pool of their initial states, and the program."""

    batch: Batch
    pool: Pool  # initial states of the prepared levels
    settings: BatchSettings
    code: Code  # of the program


@kernel
def play_matches(rollout, matches, outcome, seen):
    """Play matches until the rollout is full, a level is needed, or a program has failed.

    Observations are written into the View `seen`, whose vectors are those of the rollout's environments.
    """
    envs, batch, settings, code = rollout.envs, matches.batch, matches.settings, matches.code
    while act(rollout):
        for e in range(len(envs.action)):
            if begin_row(batch, envs.action, settings, code, e):
                play(batch.matches[e])
                run_monitors(batch, settings, code, e)
            finish_row(batch, outcome, seen, settings, e)
            note_match(rollout, outcome, settings, e)
        if has_failed(outcome.faults):
            rollout.counters[0].failed = True
            return
        if not choose_levels(rollout):
            return
        for e in range(len(envs.action)):
            if envs.restart[e]:
                start_match(rollout, matches, e)
                observe(batch, e, seen, settings.observation)


@kernel
def note_match(rollout, outcome, settings, e):
    """Record the results of a step; success is unknown (NaN) if the program defines rewards."""
    rewards = rollout.steps.reward[rollout.counters[0].step, e]
    if len(rewards) > 1:
        copy(outcome.agent_rewards[e], rewards)
    success = math.nan if settings.rewarding else 1.0 if outcome.success[e] else 0.0
    note(rollout, e, outcome.rewards[e], outcome.terminated[e], outcome.truncated[e], success)


@kernel
def has_failed(faults):
    """Return whether any match has a fault."""
    failed = False
    for e in range(len(faults)):
        failed |= faults[e] != NO_FAULT
    return failed


@kernel
def start_match(rollout, matches, e):
    """Start the next episode of an environment, on the next level if it was assigned one."""
    row, batch, pool = rollout.envs.start[e], matches.batch, matches.pool
    if row >= 0:
        batch.starts[e] = pool.matches[row]
        copy(pool.registers[row], batch.start_registers[e])
    begin_match(batch, e, start_of(luck_seed(rollout, e, True)), matches.settings)
