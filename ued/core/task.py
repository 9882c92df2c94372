"""A task: environments of your own, what students are tested on, and how levels look. The command line trains on one.

    hopper = Task(make, tests={"earth": {"gravity": 9.81, "mass": 1.0}})

    regista train examples/hopper.py:hopper --method plr

A function `make(num_envs)` alone is a task without tests. Read next: `experiments/run/tasks.py`, which reads them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ued.core.upomdp import UPOMDP

if TYPE_CHECKING:
    from ued.core.painter import ScenePainter

Make = Callable[[int], UPOMDP]


@dataclass(frozen=True)
class Task:
    """What a run trains on.

    Attributes:
        make: makes so many environments: `make(num_envs)`.
        tests: by name, what students are tested on besides random levels: θ of one level `[D]` or of several `[L, D]`;
            values by name of one level, or a list of such, where the environments have `theta_of`; or a function that
            makes environments of another kind, whose random levels are played.
        painter: makes what draws levels in recordings; None: θ is shown, and what environments render.
    """

    make: Make
    tests: Mapping[str, Any] = field(default_factory=dict)
    painter: Callable[[UPOMDP], ScenePainter] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.tests, Mapping):
            raise ValueError(f"tests must map names to levels, got {self.tests!r}")
