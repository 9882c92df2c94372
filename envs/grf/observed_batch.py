"""The kernels of a batch that GRF plays: each loops over rows of the batch.

Read next: `grf.observed_match`, the same for one match.
"""

from __future__ import annotations

from regista.envs.football.batch import begin_row, finish_row, run_monitors
from regista.envs.football.observation.observe import remember_minimap
from regista.envs.grf.observed_match import read_start, read_step
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform

SEEDS = 2_000_000_000  # GRF's own environment draws seeds from this range


@kernel
def write_seeds(matches, where, seeds):
    """Draw a seed from the stream of each of the matches `where` [k] into `seeds` [k]."""
    for at in range(len(where)):
        seeds[at] = int(uniform(matches[where[at]]) * SEEDS)


@kernel
def begin_rows(batch, actions, settings, code, playing):
    """Give all players their actions; write which matches will be stepped into `playing` [N]."""
    for index in range(len(batch.matches)):
        playing[index] = begin_row(batch, actions, settings, code, index)


@kernel
def read_starts(batch, where, observed, controllers, settings):
    """Write the initial states of matches in GRF, OBSERVED [k], into the records `where` [k]."""
    for at in range(len(where)):
        index = where[at]
        read_start(batch.matches[index], observed[at], controllers[index])
        remember_minimap(batch, index, settings.observation)


@kernel
def read_steps(batch, where, observed, controllers, settings, code):
    """Write the results of GRF's step, OBSERVED [k], into the records `where` [k], and run the monitors."""
    for at in range(len(where)):
        index = where[at]
        read_step(batch.matches[index], observed[at], controllers[index])
        run_monitors(batch, settings, code, index)


@kernel
def finish_rows(batch, outcome, seen, settings):
    """Reward and observe all matches."""
    for index in range(len(batch.matches)):
        finish_row(batch, outcome, seen, settings, index)
