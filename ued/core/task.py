"""A task: environments, test levels, and how levels are drawn. The command line trains on a task.

    hopper = Task(make, tests={"earth": {"gravity": 9.81, "mass": 1.0}})

    regista train examples/hopper.py:hopper --method plr

A function `make(num_envs)` alone is a task without tests. The minigames are tasks, too: `Minigame.task`.
Read next: `core.upomdp`, the type that `make` returns; `core.baselines`, untrained policies.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ued.core.baselines import Policy, SampledPolicy
from ued.core.level_space import check_theta
from ued.core.painter import ScenePainter
from ued.core.upomdp import UPOMDP

Make = Callable[[int], UPOMDP]
TRAINING_SCENE = "training distribution"  # random levels of `make`, evaluated beside the tests


@dataclass(frozen=True)
class Task:
    """Training environments, test scenes and settings of a run.

    Attributes:
        make: makes N environments: `make(num_envs)`.
        tests: test scenes by name: θ of one level `[D]` or of several `[L, D]`; values by name of one level, or a list
            of them, if the environments have `theta_of`; a list of levels of a `LevelFamily`; or a function
            `make(num_envs)` of other environments with the same spaces, whose random levels are evaluated.
        painter: makes a painter of levels, for pictures and recordings, from environments of this task; None: pictures
            show θ and the rendered environments.
        held_out: test scenes for final tables only (`--held-out`), in the form of `tests`.
        baselines: untrained policies by name, made for environments; "random" always exists.
        defaults: settings of a run that differ from the preset's, by dotted path: `{"ppo.gamma": 0.9}`.
        success_word: name of successful episodes in tables.
        about: one sentence about each test scene, by name, for listings.

    Raises:
        ValueError: for parts of other types, and for names of scenes or baselines that are not a single line of text
            or that equal the name of the training distribution.
    """

    make: Make
    tests: Mapping[str, Any] = field(default_factory=dict)
    painter: Callable[[UPOMDP], ScenePainter] | None = None
    held_out: Mapping[str, Any] = field(default_factory=dict)
    baselines: Mapping[str, Callable[[UPOMDP], Policy]] = field(default_factory=dict)
    defaults: Mapping[str, Any] = field(default_factory=dict)
    success_word: str = "success"
    about: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("tests", "held_out", "baselines", "defaults", "about"):
            if not isinstance(getattr(self, name), Mapping):
                raise ValueError(f"{name} must be a mapping by name, got {getattr(self, name)!r}")
        for key in (*self.tests, *self.held_out, *self.baselines):
            if not isinstance(key, str) or not key.isprintable() or not key.strip():
                raise ValueError(f"the name of a test or a baseline must be a line of text, got {key!r}")
        for key, make in (("painter", self.painter), *self.baselines.items()):
            if not callable(make) and (key, make) != ("painter", None):
                raise ValueError(f"{key} must be a function of environments, got {make!r}")
        if not isinstance(self.success_word, str) or not self.success_word.isprintable():
            raise ValueError(f"success_word must be a line of text, got {self.success_word!r}")
        if TRAINING_SCENE in self.tests or TRAINING_SCENE in self.held_out:
            raise ValueError(f"a test cannot be called '{TRAINING_SCENE}', the name of the training levels")

    def scenes(self, held_out: bool = False) -> dict[str, Any]:
        """Return the evaluation scenes by name: random levels of the training distribution, then the tests."""
        return {TRAINING_SCENE: self.make, **(self.held_out if held_out else self.tests)}

    def make_scene(self, scene: Any) -> Make:
        """Return the function that makes the environments of one of `scenes()`."""
        return scene if callable(scene) else self.make

    def make_baselines(self, upomdp: UPOMDP) -> dict[str, Policy]:
        """Return the baselines for environments of this task, by name."""
        made = {name: make(upomdp) for name, make in self.baselines.items()}
        return made if "random" in made else {**made, "random": SampledPolicy(upomdp.single_action_space)}


def theta_of_scene(scene: Any, upomdp: UPOMDP) -> np.ndarray | None:
    """Return θ `[L, D]` of the levels of one of `Task.scenes()`; None if they are random.

    Raises ValueError for levels that are neither θ of these environments nor values by name.
    """
    if callable(scene):
        return None
    try:
        rows = [scene] if isinstance(scene, Mapping) else scene
        if not hasattr(rows, "__len__"):
            raise TypeError(f"got {scene!r}")
        if len(rows) and (isinstance(rows[0], Mapping) or upomdp.level_family is not None):
            if not hasattr(upomdp, "theta_of"):
                raise TypeError(f"{type(upomdp).__name__} has no theta_of, so its levels must be theta")
            rows = [upomdp.theta_of(values) for values in rows]
        return check_theta(rows, upomdp.theta_dim)
    except (ValueError, TypeError, AttributeError) as error:
        family = upomdp.level_family
        wanted = f"theta [L, {upomdp.theta_dim}] or values by name" if family is None else _levels_of(family)
        raise ValueError(f"expected {wanted}: {error}") from error


def _levels_of(family: Any) -> str:
    return f"a list of levels of {type(family).__name__}, as its `sample` returns"
