"""Playing a policy on the test scenes of a minigame, during training and after it.

Read next: `commands.evaluate`, which makes a table of it.
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.run import build
from experiments.run.errors import CommandError

if TYPE_CHECKING:
    from experiments.run.config import TrainConfig
    from ued.evaluation import Evaluation

SEED = 20_000  # of every evaluation: all policies meet the same levels and the same luck
LEVELS_SEED = 20_001  # of levels drawn at random
ENVIRONMENTS = 64  # at most, on each scene


class TestScenes:
    """The test scenes of one minigame, ready to be played: `episodes` on each. Goals pay, whatever pays in training."""

    __test__ = False  # for pytest: these are not tests of ours

    def __init__(self, config: TrainConfig, episodes: int) -> None:
        self.episodes = episodes
        self.every = config.eval_every
        self.scenes = {
            label: self._make(label, path, config)
            for label, path in build.test_scenes(build.find_minigame(config.minigame)).items()
        }
        self._check_sizes(config)

    def play(self, policy: Any) -> dict[str, Evaluation]:
        """Play `episodes` whole episodes on each scene; `policy.play` chooses the actions."""
        from ued.evaluation import evaluate

        return {label: evaluate(policy, scene, self.episodes, SEED) for label, scene in self.scenes.items()}

    def play_random_levels(self, policy: Any, levels: int, episodes: int) -> Evaluation:
        """Play levels drawn from the training distribution, the same for every policy, `episodes` times each."""
        from ued.evaluation import evaluate

        scene = self.scenes[build.TRAINING_SCENE]
        scene.reset(seed=LEVELS_SEED)
        return evaluate(policy, scene, levels * episodes, LEVELS_SEED, scene.sample_levels(levels))

    def metrics(self, policy: Any) -> dict[str, float]:
        """Give the mean return on each scene as `eval/<scene>`, and what it cost: steps simulated, and seconds.

        These steps train nobody: they are `eval_env_steps`, not part of `env_steps`.
        """
        began, found = time.perf_counter(), self.play(policy)
        metrics = {f"eval/{label}": float(result.returns.mean()) for label, result in found.items()}
        metrics["eval_env_steps"] = float(sum(result.env_steps for result in found.values()))
        return {**metrics, "time/eval": time.perf_counter() - began}

    def due(self, before: int, after: int, last: bool) -> bool:
        """Say whether an evaluation falls between these env_steps: the first update, every `every`, and the last."""
        return bool(self.every) and (before == 0 or last or before // self.every < after // self.every)

    def _make(self, label: str, path: Path, config: TrainConfig) -> Any:
        env = replace(config.env, rewards="scoring")
        return build.make_upomdp(path, min(ENVIRONMENTS, self.episodes), env, SEED, config.threads)

    def _check_sizes(self, config: TrainConfig) -> None:
        wanted = self.scenes[build.TRAINING_SCENE].single_observation_space.shape
        for label, scene in self.scenes.items():
            found = scene.single_observation_space.shape
            if found != wanted:
                raise CommandError(
                    f"the test scene '{label}' of {config.minigame} gives observations {found}, the training program "
                    f"{wanted}: they need the same players"
                )
