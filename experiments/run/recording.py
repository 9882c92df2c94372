"""The recording of one run: what its updates brought, and episodes of its students on the level of the highest score.

Read next: `ued.recorder.recorder`.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from experiments.run import build
from experiments.run import config as configs
from experiments.run.folder import RunFolder
from experiments.run.mixed import MixedProgram
from experiments.run.reporting import Update
from experiments.run.table import read_columns
from experiments.run.tasks import TaskScene
from ued.recorder.recorder import CurriculumRecorder, Recording
from ued.recorder.scene_log import Episode, by_score, titles

MAX_STEPS = 400  # of a recorded episode
STEP_SECONDS = 0.1  # of an environment that says nothing of it


class RunRecorder:
    """Feed a `CurriculumRecorder` from a method, and play the episodes that it shows."""

    def __init__(self, run: RunFolder, program: Any, upomdp: Any, updates: int, connect: str | None = None) -> None:
        self.run, config = run, run.config
        if isinstance(program, TaskScene):
            self.painter: Any = program.task.painter(upomdp) if program.task.painter else None
            self.env = build.make_upomdp(program, 1, None, config.seed, config.threads)
        else:
            lineup = None if isinstance(program, MixedProgram) else upomdp.lineup
            self.painter = build.make_painter(program, lineup)
            self.env = upomdp.resized(1)
        self.env.reset(seed=config.seed)
        name = f"{config.minigame} {config.method} seed {config.seed}"
        flat = {key: str(value) for key, value in configs.to_dict(config).items() if not isinstance(value, dict)}
        recording = Recording(run.next_recording(), run.recording_id, name, config.total_env_steps, flat, connect)
        self.step_seconds = 1 / (self.env.metadata.get("render_fps") or 1 / STEP_SECONDS)
        self.recorder: CurriculumRecorder | None = CurriculumRecorder(recording, self.painter, upomdp.draws)
        if updates:
            self._recall()

    def flush(self) -> None:
        """Bring everything to the disk; end the recording where it has become larger than it may be."""
        if self.recorder is not None:
            self.recorder.flush()
        size, most = sum(part.stat().st_size for part in self.run.recordings()), self.run.config.record_limit
        if self.recorder is not None and size > most * 1_000_000:
            self.close()
            self.recorder = None
            print(f"regista: {most} MB are recorded, and nothing more is; see --record-limit", file=sys.stderr)

    def close(self) -> None:
        """Finish the file."""
        if self.recorder is not None:
            self.recorder.close()

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

    def report(self, update: Update) -> None:
        """Record an update; now and then let the students play the level of the highest score."""
        method, levels, every = update.method, update.levels, self.run.config.record_rollouts
        if self.recorder is None or levels is None:
            return
        self.recorder.record(update.number, update.env_steps, levels, update.metrics)
        if hasattr(method, "curriculum") and hasattr(method.curriculum, "buffer"):
            self.recorder.level_buffer(update.number, method.curriculum.buffer)
        for event in update.events:
            self.recorder.event(event.event, event.text)
        if every and len(levels.theta) and (update.number == 1 or update.number % every == 0):
            best = int(by_score(levels)[0])
            for name, student in method.students.items():
                episode = self._play(student, levels.records["level"][best : best + 1], update.number)
                text = f"{name} at update {update.number} on {titles(levels)[best]}: {episode.outcome}"
                self.recorder.episode(name, update.number, update.env_steps, episode._replace(outcome=text))

    def _play(self, student: Any, level: np.ndarray, seed: int) -> Episode:
        """Play an episode on a level `[1]`, with the luck of its score; both students of an update draw alike."""
        import torch

        generator = torch.Generator().manual_seed(seed)
        observation, _ = self.env.reset_to_levels(level)
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
