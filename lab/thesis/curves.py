"""Learning curves of chapter 4 (Figure 4.9): returns of the agent, of the antagonist, and of the environment.

The environment's return is the adversary's reward, the mean regret of its own levels. Read next:
`lab/thesis/figures.py`, which draws them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from regista.experiments.run import versions
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.table import read_columns

POINTS = 20  # of each curve
CURVES = ("agent", "antagonist", "environment")


class Value(NamedTuple):
    """A point of a curve: the mean over the updates of a twentieth of a run, which ends after `env_steps`."""

    game: str
    agent: str
    seed: int
    env_steps: int
    curve: str  # of CURVES
    value: float
    simulator: str  # as in `lab.studies.rows.Row`

    def key(self) -> tuple[str, str, int, int, str]:
        """Return the key of the value; a later value with the same key replaces it."""
        return self[:5]


def curves_of(run: RunFolder, agent: str) -> list[Value]:
    """Return the curves of a run from its metrics; points without a finished episode are left out."""
    metrics = read_columns(run.metrics.path)
    student = next(name for name in metrics if name.startswith("return/"))
    columns = dict(zip(CURVES, (student, "return/antagonist", "regret"), strict=True))
    part = np.minimum((metrics["env_steps"] - 1) * POINTS // run.config.total_env_steps, POINTS - 1).astype(int)
    version = versions.spelled(versions.present_version(run.config))
    values = []
    for k in range(POINTS):
        steps = (k + 1) * run.config.total_env_steps // POINTS
        for curve, column in columns.items():
            known = metrics[column][part == k] if column in metrics else np.empty(0)
            known = known[np.isfinite(known)]
            if len(known):
                about = (run.config.minigame, agent, run.config.seed, steps, curve)
                values.append(Value(*about, round(float(known.mean()), 4), version))
    return values
