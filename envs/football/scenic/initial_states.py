"""Initial states of matches on given levels, made for many levels at once: a hundred take hardly longer than one.

Read next: `vector_env`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from regista.envs.football.scenic.compiled_behaviors import CompiledBehaviors
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.state import MATCH

BLOCK = 128  # levels made ahead at most
INVALID = -1


class InitialStates:
    """The initial states of a block of levels: those requested, and those expected next.

    An initial state depends on θ alone, so results do not depend on which levels share a block. The environment sets
    its random stream, which is new in every episode.

    Attributes:
        matches: MATCH `[B]` of the valid levels of the block; registers: `[B, R]`, of the program's behaviors.
    """

    def __init__(self, lineup: Lineup, behaviors: CompiledBehaviors) -> None:
        self._lineup, self._behaviors = lineup, behaviors
        self.matches, self.registers = np.zeros(0, MATCH), np.zeros((0, behaviors.num_registers))
        self._rows: dict[bytes, int] = {}  # of each level of the block; INVALID for unplayable ones

    def rows(self, levels: np.ndarray, upcoming: Callable[[], np.ndarray] | None) -> np.ndarray:
        """Return the indices of levels `[k]` into `matches` and `registers`: `[k]`, or INVALID.

        `upcoming` returns the levels that are likely to be requested next.
        """
        keys = _keys(levels)
        if not self._rows.keys() >= set(keys):
            self._make(levels if upcoming is None else np.concatenate([levels, upcoming()[:BLOCK]]))
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
