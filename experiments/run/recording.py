"""The recording of one run: its updates, and episodes of its students on the levels with the highest scores.

Read next: `run.replays`; `ued.recorder.recorder`.
"""

from __future__ import annotations

import socket
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from regista.experiments.run import build, replays, versions
from regista.experiments.run import config as configs
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.replays import Played, Replay, Stage
from regista.experiments.run.reporting import Update
from regista.experiments.run.table import read_columns
from ued.config import PairedConfig, PairedLiteralConfig
from ued.core.task import Task
from ued.methods import METHODS
from ued.recorder.layout import TOP_LEVELS
from ued.recorder.recorder import CurriculumRecorder, Recording
from ued.recorder.scene_log import Episodes, titles

MAX_FRAMES = 400  # maximum over all recorded episodes on a level


class RunRecorder:
    """Passes the levels and episodes of a method to a `CurriculumRecorder` and to replays.csv."""

    def __init__(self, run: RunFolder, task: Task, method: Any, connect: str | None = None) -> None:
        self.run, config, upomdp = run, run.config, method.upomdp
        env = build.make_upomdp(task.make, 1, config.seed)
        self.stage = Stage(env, task.painter(upomdp) if task.painter else None)
        if connect is not None and not viewer_answers(connect):
            print(f"regista: no viewer at {connect}: live view disabled; see rerun --port", file=sys.stderr)
            connect = None
        name = f"{config.minigame} {config.method} seed {config.seed}"
        flat = {key: str(value) for key, value in configs.to_dict(config).items() if not isinstance(value, dict)}
        flat |= {key: str(version) for key, version in versions.stamp(config).items()}
        rule, steps = score_rule(getattr(config, METHODS[config.method].group, None)), config.total_env_steps
        recording = Recording(run.next_recording(), run.recording_id, name, steps, flat, connect, rule)
        self.recorder: CurriculumRecorder | None = CurriculumRecorder(recording, self.stage.painter, upomdp.parameters)
        if config.record_rollouts:
            method.keep_tapes()
        if method.updates:
            self._recall()

    def flush(self) -> None:
        """Write everything to disk; end the recording if it exceeds its maximum size."""
        if self.recorder is not None:
            self.recorder.flush()
        size, most = sum(part.stat().st_size for part in self.run.recordings()), self.run.config.record_limit
        if self.recorder is not None and size > most * 1_000_000:
            self.close()
            self.recorder = None
            print(f"regista: the recording has reached {most} MB and ends; see --record-limit", file=sys.stderr)

    def close(self) -> None:
        """Finish the file."""
        if self.recorder is not None:
            self.recorder.close()

    def _recall(self) -> None:
        """Pass the levels of updates in an earlier part of the recording to the recorder."""
        levels, metrics = read_levels(self.run.path, "update", "theta/"), read_columns(self.run.metrics.path)
        if not levels or self.recorder is None:
            return
        theta = np.stack([column for name, column in levels.items() if name.startswith("theta/")], 1)
        starts = np.flatnonzero(np.diff(levels["update"], prepend=-1.0))
        for rows in np.split(np.arange(len(theta)), starts[1:]):
            update = int(levels["update"][rows[0]])
            self.recorder.recall(update, int(metrics["env_steps"][update - 1]), theta[rows])

    def report(self, update: Update) -> None:
        """Record an update, save replays of the levels with the highest scores, and periodically show one."""
        method, levels, every = update.method, update.levels, self.run.config.record_rollouts
        if self.recorder is None or levels is None:
            return
        self.recorder.record(update.number, update.env_steps, levels, update.metrics)
        if method.buffer is not None:
            self.recorder.level_buffer(update.number, method.buffer)
        for event in update.events:
            self.recorder.event(event.event, event.text)
        if every:
            saved = replays.taken(method, update.number, TOP_LEVELS)
            self.run.replays.append([replay.row() for replay in saved])
            if update.number == 1 or update.number % every == 0:
                self._show([replay for replay in saved if replay.visit == saved[0].visit], update)

    def _show(self, saved: Sequence[Replay], update: Update) -> None:
        """Record the replayed episodes of all students on one level."""
        assert update.levels is not None and self.recorder is not None
        named = dict(zip(update.levels.records["visit"].tolist(), titles(update.levels), strict=True))
        for replay in saved:
            played = self.stage.play(replay)
            text = f"{replay.student} in update {update.number}\n{named[replay.visit]}"
            if not replays.came_out_alike(replay, played.returns):
                text += "\nreplay differs from the recorded episodes: the environment uses randomness beyond its seed"
            episodes = Episodes(
                np.array(played.frames[:MAX_FRAMES]),
                [begin for begin in played.begins if begin < MAX_FRAMES],
                self.stage.step_seconds,
                text,
                endings(replay, played),
            )
            self.recorder.episodes(replay.student, update.number, update.env_steps, episodes)


def endings(replay: Replay, played: Played) -> list[str]:
    """Return the outcome of each episode in a few words, with a mark for partly recorded episodes."""
    lasts = [*(begin - 1 for begin in played.begins[1:]), len(played.frames) - 1]
    whole = sum(last < MAX_FRAMES for last in lasts[: len(played.returns)])
    return [f"return {value:+.2f}" + " (cut off)" * (k >= whole) for k, value in enumerate(replay.returns)]


def score_rule(settings: Any) -> str:
    """Return the score rule of a method with these settings, in the form that `ued.recorder.cards.formula` accepts."""
    if isinstance(settings, PairedLiteralConfig):
        return f"dennis2020 {settings.regret}"
    if isinstance(settings, PairedConfig):
        roles = "dennis2020" if settings.antagonist == "scripted" else settings.roles
        return f"{roles} {settings.regret}"
    return getattr(settings, "score", "")


def viewer_answers(address: str) -> bool:
    """Return whether a server listens at HOST:PORT."""
    host, _, port = address.rpartition(":")
    try:
        socket.create_connection((host or "127.0.0.1", int(port)), timeout=2.0).close()
    except (OSError, ValueError, OverflowError):
        return False
    return True
