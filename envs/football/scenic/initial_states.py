"""Initial states of matches on given levels, computed in blocks: 100 levels take hardly longer than one.

Read next: `vector_env`.
"""

from __future__ import annotations

import numpy as np

from regista.envs.football.scenic.compiled_behaviors import CompiledBehaviors
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.state import MATCH

INVALID = -1


class InitialStates:
    """A cache of the initial states of a block of levels: the requested and the prefetched ones.

    An initial state depends on θ alone, so results do not depend on which levels share a block. The environment sets
    the random stream of a match, which is new in every episode.

    Attributes:
        matches: MATCH `[B]` of the valid levels of the block; registers: `[B, R]`, of the program's behaviors.
    """

    def __init__(self, lineup: Lineup, behaviors: CompiledBehaviors) -> None:
        self._lineup, self._behaviors = lineup, behaviors
        self.matches, self.registers = np.zeros(0, MATCH), np.zeros((0, behaviors.num_registers))
        self._rows: dict[bytes, int] = {}  # row of each level of the block; INVALID for unplayable levels
        self._coming: list[np.ndarray] = []  # prefetched levels, in at most one array

    def prefetch(self, levels: np.ndarray) -> None:
        """Compute the initial states of these levels `[k]` together with the next block."""
        self._coming = [levels]

    def rows(self, levels: np.ndarray) -> np.ndarray:
        """Return the indices of levels `[k]` into `matches` and `registers`: `[k]`, or INVALID.

        If any level is missing, these levels and the prefetched ones replace the block.
        """
        keys = _keys(levels)
        if not self._rows.keys() >= set(keys):
            self._make(np.concatenate([levels, *self._coming]))
        return np.array([self._rows[key] for key in keys], np.int64)

    def _make(self, levels: np.ndarray) -> None:
        scenes = self._lineup.program.instantiate(levels["theta"])
        valid = np.flatnonzero(scenes.ok)
        self._rows = dict.fromkeys(_keys(levels), INVALID)
        self._rows |= {key: row for row, key in enumerate(_keys(levels[valid]))}
        if len(valid):
            self.matches = self._lineup.starts_of(scenes, valid, np.zeros(len(valid), np.uint64))
            self.registers = self._behaviors.registers(levels["theta"][valid])


def _keys(levels: np.ndarray) -> list[bytes]:
    return [theta.tobytes() for theta in levels["theta"]]
