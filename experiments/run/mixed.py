"""A mixture of minigames: programs that one run trains on, of which its teacher chooses as it chooses levels.

    regista train grf/empty_goal_close+grf/empty_goal --method plr
    regista train AcademyLadder --method paired

It is written as names joined by +, not as one Scenic program: a program has the same players in all its scenes, and
the games of a ladder have not. Read next: `ued.adapters.mixture`; `run.build`, which makes environments of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ued.core.cells import index_in
from ued.core.level_space import level_dtype

if TYPE_CHECKING:
    from regista.envs.football.view.render import FootballPainter
    from scenic_lite import Program


@dataclass(frozen=True)
class MixedProgram:
    """The programs of a mixture. Where `only` is an index, that one is played whatever θ says: a test scene."""

    names: tuple[str, ...]
    programs: tuple[Program, ...]
    only: int | None = None

    @property
    def source(self) -> str:
        """The texts of all programs, each below its name."""
        return "\n".join(f"# {name}\n{program.source}" for name, program in zip(self.names, self.programs, strict=True))

    def single_program(self, index: int, program: Program) -> MixedProgram:
        """Return the mixture in which this program is played in the place of number `index`, and no other."""
        others = self.programs[:index], self.programs[index + 1 :]
        return replace(self, programs=(*others[0], program, *others[1]), only=index)

    def member_of(self, level: np.ndarray) -> tuple[Program, np.ndarray]:
        """Return the program that a level `[1]` of the mixture is of, and the level as that program's own."""
        theta = level["theta"][0]
        program = self.programs[int(index_in(theta[0], len(self.programs)))]
        own = np.zeros(1, level_dtype(program.dim))
        own["seed"], own["theta"] = level["seed"], theta[1 : 1 + program.dim]
        return program, own


class MixedPainter:
    """Tell what the levels of a mixture look like. It is a `ued.recorder.layout.ScenePainter`.

    It has as many points of each class as any of the programs; those that a level has no use for are nan. The ball
    stands for a level: every program has one.
    """

    def __init__(self, painters: Sequence[FootballPainter], dims: Sequence[int]) -> None:
        first = painters[0]
        self.background, self.line_colour, self.markers = first.background, first.line_colour, first.markers
        self.painters, self.dims = tuple(painters), tuple(dims)
        widest = max(painters, key=lambda painter: painter.bounds[1] - painter.bounds[0])
        self.lines = widest.lines
        ends = np.array([painter.bounds for painter in painters])  # [K, 4]
        low, high = ends.min(0), ends.max(0)
        self.bounds = (float(low[0]), float(high[1]), float(low[2]), float(high[3]))
        self.reach = first.reach
        kinds = range(len(self.markers))
        counts = [max(int((painter.classes == kind).sum()) for painter in painters) for kind in kinds]
        self.classes = np.repeat(kinds, counts)
        self.focus = len(self.classes) - 1
        starts = np.cumsum([0, *counts])
        self._slots = [_slots(painter.classes, starts) for painter in painters]  # where each program's points go

    def positions(self, theta: np.ndarray) -> np.ndarray:
        """Return the places in the scenes of θ `[L, 1 + max D]`: `[L, K, 2]` m."""
        program = index_in(theta[:, 0], len(self.painters))
        places = np.full((len(theta), len(self.classes), 2), np.nan)
        for k, painter in enumerate(self.painters):
            mine = np.flatnonzero(program == k)
            if len(mine):
                places[np.ix_(mine, self._slots[k])] = painter.positions(theta[mine, 1 : 1 + self.dims[k]])
        return places

    def frame(self, env: Any) -> np.ndarray:
        """Return the places in the first environment of a mixture as it stands: `[K, 2]` m."""
        k = int(env.levels["program"][0])
        places = np.full((len(self.classes), 2), np.nan)
        places[self._slots[k]] = self.painters[k].frame(env.members[k])
        return places


def _slots(classes: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return for points of these classes the places that they take where each class begins at `starts`."""
    rank = [int((classes[:index] == kind).sum()) for index, kind in enumerate(classes)]
    return starts[classes] + rank
