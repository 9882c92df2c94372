"""What a football program says of itself in comments, checked in the simulator.

    # expect at 60: abs(forward.x - 60) < 8
    # expect by 40: runner.sprint == 1
    # expect always: keeper.x < -90

Names are the program's objects with the columns of the world table (`football.scenic.world_fields.FIELDS`),
`<name>_start` is an object at kick-off, `distance(a, b)` is what it says. A line holds if it does in most of the
matches played, each on a random level and without a learner; a match that ends sooner than the time named does not
count for `at` and `by`.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from pitch import take_over

from regista.envs.football.constants import NOBODY
from regista.envs.football.scenic.world_fields import FACTS, FIELDS
from regista.envs.football.scenic.world_table import NUM_FIELDS, write_world
from regista.envs.football.vector_env import FootballVectorEnv

LINE = re.compile(r"^# expect (?:(always)|(at|by) (\d+)): (.+)$", re.MULTILINE)
MATCHES, MOST = 16, 0.75


class Expectation(NamedTuple):
    when: str  # "always", "at", "by"
    step: int
    condition: str


def expectations(path: Path) -> list[Expectation]:
    found = LINE.findall(path.read_text())
    assert len(found) == path.read_text().count("# expect"), f"{path.name} has an expectation that is none"
    return [Expectation(always or when, int(step or 0), condition) for always, when, step, condition in found]


class Course:
    """What has happened in one match: for each step the names that expectations speak of."""

    def __init__(self) -> None:
        self.steps: list[dict[str, SimpleNamespace]] = []
        self.over = False

    def holds(self, expectation: Expectation) -> bool | None:
        """Return whether it does; None if the match was too short to tell."""
        seen = [self._truth(expectation.condition, names) for names in self.steps[: expectation.step + 1 or None]]
        if expectation.when == "always":
            return all(self._truth(expectation.condition, names) for names in self.steps)
        if expectation.when == "by" and any(seen):
            return True
        return None if len(self.steps) <= expectation.step else seen[-1]

    def _truth(self, condition: str, names: dict[str, SimpleNamespace]) -> bool:
        start = {f"{name}_start": place for name, place in self.steps[0].items()}
        known = {"abs": abs, "any": any, "all": all, "distance": distance, **start, **names}
        return bool(eval(condition, {"__builtins__": {}} | known))


def distance(a: SimpleNamespace, b: SimpleNamespace) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def courses(path: Path, steps: int, count: int = MATCHES) -> list[Course]:
    """Play a program without a learner on random levels, each until its first episode is over."""
    env = FootballVectorEnv(path, count)
    env.reset(seed=0)
    for matches in (env._batch.matches, env._batch.starts):  # nobody is the learner's
        take_over(matches, NOBODY)
    played = [Course() for _ in range(count)]
    note(env, played)
    for _ in range(steps):
        _, _, terminated, truncated, _ = env.step(np.zeros(count, int))
        for course, ended in zip(played, terminated | truncated, strict=True):
            course.over |= bool(ended)
        note(env, played)
    return played


def note(env: FootballVectorEnv, played: list[Course]) -> None:
    """Write down where everybody is in the matches that go on."""
    object_to_player = env.lineup.object_to_player
    names = [info.name for info in env.program.objects]
    row = np.zeros(len(object_to_player) * NUM_FIELDS + len(FACTS))
    for match, course in zip(env.matches.view(np.recarray), played, strict=True):
        if not course.over:
            write_world(match, object_to_player, row, 0)
            cells = row[: len(object_to_player) * NUM_FIELDS].reshape(len(object_to_player), NUM_FIELDS).tolist()
            course.steps.append(
                {
                    name: SimpleNamespace(**dict(zip(FIELDS, cell, strict=True)))
                    for name, cell in zip(names, cells, strict=True)
                    if name
                }
            )
