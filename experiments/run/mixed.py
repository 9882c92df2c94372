"""A mixture of tasks: one run trains on all of them, and its teacher chooses the task as part of the level.

    regista train grf/empty_goal_close+grf/empty_goal --method plr
    regista train AcademyLadder --method paired

A mixture is written as names joined by +. It is not one Scenic program, because a program has the same players in all
of its scenes. Read next: `ued.adapters.mixture`, the environments.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from regista.experiments.run.errors import UsageError
from ued.core.cells import index_in
from ued.core.painter import ScenePainter, line_color_of
from ued.core.task import Make, Task
from ued.core.upomdp import UPOMDP


def mixed_task(tasks: Mapping[str, Task]) -> Task:
    """Combine several tasks, by name, into one. Its tests are all tasks and all of their test scenes.

    Tests of the tasks must be functions that make environments, since levels of one task are not levels of the mixture.
    """
    names, makes = tuple(tasks), [task.make for task in tasks.values()]

    def scenes(tests: Sequence[Mapping[str, Any]]) -> dict[str, Make]:
        found: dict[str, Make] = {}
        for k, name in enumerate(names):
            found[name] = partial(_mixture, makes, names, k)
            for label, test in tests[k].items():
                found[f"{name}/{label}"] = partial(_mixture, [*makes[:k], test, *makes[k + 1 :]], names, k)
        return found

    held_out, painters = [task.held_out for task in tasks.values()], [task.painter for task in tasks.values()]
    words = {task.success_word for task in tasks.values()}
    return Task(
        partial(_mixture, makes, names, None),
        scenes([task.tests for task in tasks.values()]),
        painter=partial(_painter, painters) if all(painters) else None,
        held_out=scenes(held_out) if all(held_out) else {},
        success_word=words.pop() if len(words) == 1 else "success",
    )


def _mixture(makes: Sequence[Make], names: tuple[str, ...], only: int | None, num_envs: int) -> UPOMDP:
    """Make the environments of a mixture; with the index `only`, all θ select that task."""
    from ued.adapters.mixture import Mixture

    members = [make(num_envs) for make in makes]
    try:
        return Mixture(members, names, only)
    except ValueError as error:
        raise UsageError(f"these minigames cannot be mixed: {error}") from error


def _painter(painters: Sequence[Any], upomdp: Any) -> MixedPainter:
    members = upomdp.members
    made = [painter(member) for painter, member in zip(painters, members, strict=True)]
    return MixedPainter(made, [member.theta_dim for member in members])


class MixedPainter:
    """Painter of the levels of a mixture, a `ued.core.painter.ScenePainter`.

    For each class, it has the maximum number of points over the tasks; unused points of a level are nan. The ball is
    the focus, since every football game has one.
    """

    def __init__(self, painters: Sequence[ScenePainter], dims: Sequence[int]) -> None:
        first = painters[0]
        self.background, self.line_color, self.markers = first.background, line_color_of(first), first.markers
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
        self._slots = [_slots(painter.classes, starts) for painter in painters]  # indices of each task's points

    def positions(self, theta: np.ndarray) -> np.ndarray:
        """Return the points in the scenes of θ `[L, 1 + max D]`: `[L, K, 2]` m."""
        program = index_in(theta[:, 0], len(self.painters))
        places = np.full((len(theta), len(self.classes), 2), np.nan)
        for k, painter in enumerate(self.painters):
            mine = np.flatnonzero(program == k)
            if len(mine):
                places[np.ix_(mine, self._slots[k])] = painter.positions(theta[mine, 1 : 1 + self.dims[k]])
        return places

    def frame(self, env: Any) -> np.ndarray:
        """Return the current points of the first environment of a mixture: `[K, 2]` m."""
        k = int(env.levels["program"][0])
        places = np.full((len(self.classes), 2), np.nan)
        places[self._slots[k]] = self.painters[k].frame(env.members[k])
        return places


def _slots(classes: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return the indices of points of these classes, given the first index of each class in `starts`."""
    rank = [int((classes[:index] == kind).sum()) for index, kind in enumerate(classes)]
    return starts[classes] + rank
