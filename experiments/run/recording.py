"""The recording of one run, which never stops the run: if it fails it says so once and is over.

Read next: `ued.recorder.recorder`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from experiments.run import build
from experiments.run import config as configs
from experiments.run.folder import RunFolder
from experiments.run.mixed import MixedProgram
from experiments.run.table import read_columns
from experiments.run.tasks import TaskScene
from ued.recorder.recorder import CurriculumRecorder, Recording
from ued.recorder.scene_log import Episode

MAX_STEPS = 400  # of a recorded episode
STEP_SECONDS = 0.1  # of an environment that says nothing of it


class RunRecorder:
    """Feed a `CurriculumRecorder` from a method, and play the episodes that it shows."""

    def __init__(self, run: RunFolder, program: Any, upomdp: Any, updates: int) -> None:
        self.run = run
        self.recorder: CurriculumRecorder | None = None
        if run.config.record:
            self._try(self._open, program, upomdp, updates)

    def update(self, method: Any, metrics: dict[str, float]) -> None:
        """Record what `method.update()` brought."""
        self._try(self._update, method, metrics)

    def flush(self) -> None:
        """Bring everything to the disk; end the recording where it has become larger than it may be."""
        if self.recorder is not None:
            self._try(self.recorder.flush)
        size, most = sum(part.stat().st_size for part in self.run.recordings()), self.run.config.record_limit
        if self.recorder is not None and size > most * 1_000_000:
            self.close()
            self.recorder = None
            print(f"regista: {most} MB are recorded, and nothing more is; see --record-limit", file=sys.stderr)

    def close(self) -> None:
        """Finish the file."""
        if self.recorder is not None:
            self._try(self.recorder.close)

    def _try(self, action: Callable[..., None], *args: Any) -> None:
        try:
            action(*args)
        except Exception as error:
            self.recorder = None
            print(f"regista: nothing more is recorded: {type(error).__name__}: {error}", file=sys.stderr)

    def _open(self, program: Any, upomdp: Any, updates: int) -> None:
        config = self.run.config
        if isinstance(program, TaskScene):
            self.painter: Any = program.task.painter(upomdp) if program.task.painter else None
            self.env = build.make_upomdp(program, 1, None, config.seed, config.threads)
        else:
            lineup = None if isinstance(program, MixedProgram) else upomdp.lineup
            self.painter = build.make_painter(program, lineup)
            self.env = upomdp.resized(1)
        name = f"{config.minigame} {config.method} seed {config.seed}"
        flat = {key: str(value) for key, value in configs.to_dict(config).items() if not isinstance(value, dict)}
        recording = Recording(self.run.next_recording(), name, config.total_env_steps, flat)
        self.step_seconds = 1 / (self.env.metadata.get("render_fps") or 1 / STEP_SECONDS)
        self.recorder = CurriculumRecorder(recording, self.painter, upomdp.draws)
        if updates:
            self._recall()

    def _recall(self) -> None:
        """Return the recorder the levels of the updates that an earlier part of the recording holds."""
        levels, metrics = read_columns(self.run.levels.path), read_columns(self.run.metrics.path)
        if not levels or self.recorder is None:
            return
        theta = np.stack([column for name, column in levels.items() if name.startswith("theta/")], 1)
        starts = np.flatnonzero(np.diff(levels["update"], prepend=-1.0))
        for rows in np.split(np.arange(len(theta)), starts[1:]):
            update = int(levels["update"][rows[0]])
            self.recorder.recall(update, int(metrics["env_steps"][update - 1]), theta[rows])

    def _update(self, method: Any, metrics: dict[str, float]) -> None:
        if self.recorder is None or method.last is None:
            return
        self.recorder.record(method.updates, method.env_steps, method.last, metrics)
        every = self.run.config.record_rollouts
        if every and len(method.last.theta) and (method.updates == 1 or method.updates % every == 0):
            score = np.nan_to_num(method.last.score, nan=-np.inf)
            theta = method.last.theta[int(np.argmax(score))]
            for name, student in method.students.items():
                self.recorder.episode(
                    name, method.updates, method.env_steps, self._play(student, theta, method.updates)
                )

    def _play(self, student: Any, theta: np.ndarray, seed: int) -> Episode:
        """Play one episode; both students of an update get the same level and the same luck."""
        import torch

        generator = torch.Generator().manual_seed(seed)
        observation, _ = self.env.reset(seed=seed, options={"theta": theta[None]})
        frames, total, steps = [self._frame()], 0.0, 0
        for _ in range(MAX_STEPS):
            observation, reward, terminated, truncated, _ = self.env.step(student.play(observation, generator))
            total, steps = total + float(reward[0]), steps + 1
            if terminated[0] or truncated[0]:
                break
            frames.append(self._frame())
        shown = [frame for frame in frames if frame is not None]
        return Episode(np.array(shown), self.step_seconds, f"return {total:+.2f} after {steps} steps")

    def _frame(self) -> np.ndarray | None:
        """Return what is shown of the environment as it stands: places `[K, 2]`, or an image, or nothing."""
        if self.painter is not None:
            return self.painter.frame(self.env)
        images = self.env.render() if self.env.render_mode == "rgb_array" else None
        return None if images is None else np.asarray(images[0], np.uint8)
