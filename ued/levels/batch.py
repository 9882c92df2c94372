"""The levels of an update, and the columns of levels.csv for each.

Read next: `levels.record`, the fields of a level record; `recorder.recorder`, which shows them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ued.levels.record import NEGATIVE, NONE, Origin, mean_played, mean_returns, solved

SOURCES = np.array([origin.name.lower() for origin in Origin])
VALUES = {"value": "mean_value", "positive_advantage": "positive_advantage", "absolute_advantage": "absolute_advantage"}


@dataclass(frozen=True)
class LevelBatch:
    """The L levels of an update: level records `[L]`, and the names of their students."""

    records: np.ndarray
    students: Sequence[str]

    @property
    def theta(self) -> np.ndarray:
        """The θ of the levels: `[L, D]`."""
        return self.records["level"]["theta"]

    @property
    def score(self) -> np.ndarray:
        """The score of each level (PAIRED: regret), `[L]`; nan without a score."""
        return self.records["score"]

    @property
    def source(self) -> np.ndarray:
        """The origin of each level as a word, `[L]`."""
        return SOURCES[self.records["origin"]]

    @property
    def returns(self) -> dict[str, np.ndarray]:
        """For each student, the mean undiscounted return `[L]` over its whole episodes; nan without an episode."""
        return dict(zip(self.students, mean_returns(self.records).T, strict=True))

    @property
    def best(self) -> dict[str, np.ndarray]:
        """For each student, the highest of these returns `[L]`."""
        best = np.fmax.reduce(self.records["returns"], 2)
        return dict(zip(self.students, best.T, strict=True))

    @property
    def episodes(self) -> dict[str, np.ndarray]:
        """For each student, the number of its whole episodes `[L]`."""
        return dict(zip(self.students, self.records["num_played"].T.astype(np.int64), strict=True))

    def facts(self) -> dict[str, np.ndarray]:
        """Return the identifiers of each level, by name `[L]`: id, visit, source, parent (nan: none), program, ..."""
        level, parent = self.records["level"], self.records["parent"]
        return {
            "id": self.records["id"],
            "visit": self.records["visit"],
            "source": self.source,
            "parent": np.where(parent == NONE, np.nan, parent),
            "program": level["program"],
            "seed": level["seed"],
            "episodes": self.records["num_played"].min(1, initial=np.iinfo(np.int32).max),
        }

    def outcomes(self) -> dict[str, np.ndarray]:
        """Return the results of students on each level, by name `[L]`, and its score.

        return, best, success: of each student, over its episodes. Methods whose scores may use values, such as PLR, add
        more columns: best_ever, the highest return ever on the level, and means over episodes. These are the means of
        V, max(A, 0), |A| and the sum that the score mna needs. CENIE adds the novelty, nan before the first mixture.
        """
        columns = {f"return/{name}": values for name, values in self.returns.items()}
        columns |= {f"best/{name}": values for name, values in self.best.items()}
        success = mean_played(solved(self.records))  # [L, S]
        columns |= {f"success/{name}": success[:, index] for index, name in enumerate(self.students)}
        if "best" in (self.records.dtype.names or ()):
            columns["best_ever"] = self.records["best"]
            fields = VALUES | ({NEGATIVE: NEGATIVE} if NEGATIVE in (self.records.dtype.names or ()) else {})
            columns |= {name: mean_played(self.records[field][:, 0]) for name, field in fields.items()}
        if "novelty" in (self.records.dtype.names or ()):
            novelty = mean_played(self.records["novelty"][:, 0])
            columns["novelty"] = np.where(np.isfinite(novelty), novelty, np.nan)
        return columns | {"score": self.score}
