"""Replays of the episodes that determined a level's score, saved in a table of the run.

A row holds a level with its seed and a student's actions on it. An environment that is reset to that level and steps
through these actions repeats the same episodes, without the student. Read next: `ued.learning.tape`.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from regista.experiments.run.errors import CommandError
from regista.experiments.run.rendering import fitted, rendered
from ued.core.level_space import level_dtype
from ued.core.painter import ScenePainter
from ued.core.upomdp import UPOMDP

MAX_STEPS = 2_000  # total over all saved episodes on one level
STEP_SECONDS = 0.1  # default of environments without render_fps


@dataclass(frozen=True)
class Replay:
    """A student's actions on a level, in all of its episodes of one visit.

    Attributes:
        update, id, visit: numbers of the update, of the level, and of the visit.
        student: name of the student.
        level: the level, a record of `level_dtype(D)` `[1]`.
        actions: `[T, ...]`, as passed to the environment.
        returns: returns of the recorded episodes `[n]`.
    """

    update: int
    id: int
    visit: int
    student: str
    level: np.ndarray
    actions: np.ndarray
    returns: np.ndarray

    def row(self) -> dict[str, Any]:
        """Return the row of replays.csv."""
        return {
            "update": self.update,
            "id": self.id,
            "visit": self.visit,
            "student": self.student,
            "returns": " ".join(np.format_float_positional(value, trim="-") for value in self.returns),
            "level": _spell(self.level),
            "actions": _spell(self.actions.astype(_saved_dtype(self.actions.dtype))),
        }

    @classmethod
    def of_row(cls, row: Mapping[str, str], upomdp: Any) -> Replay:
        """Read a row of replays.csv for these environments. Raises `CommandError` for a damaged row."""
        dtype, space = level_dtype(upomdp.theta_dim), upomdp.single_action_space
        try:
            level = np.frombuffer(_read(row["level"], dtype.itemsize), dtype).reshape(1)
            saved = _saved_dtype(space.dtype)
            data = _read(row["actions"], MAX_STEPS * max(int(np.prod(space.shape)), 1) * saved.itemsize)
            actions = np.frombuffer(data, saved).astype(space.dtype).reshape(-1, *space.shape)
            returns = np.array(row["returns"].split(), float)
            update, number, visit = (int(row[name]) for name in ("update", "id", "visit"))
            return cls(update, number, visit, row["student"], level, actions, returns)
        except (ValueError, KeyError, zlib.error) as error:
            raise CommandError(f"a row of replays.csv is damaged: {error}") from error


def taken(method: Any, update: int, most: int) -> list[Replay]:
    """Return replays of all students on the levels with the highest scores of the last update, at most `most` levels.

    Levels with incomplete data, because they started before a kill, are skipped.
    """
    batch = method.last
    records, tapes, replays = batch.records, {}, []
    for index, learner in enumerate(method.learners):
        if learner.student is not None and learner.worker.tape is not None:
            tapes[index] = learner.worker.tape.pop(records["visit"])
    order = np.argsort(-np.nan_to_num(batch.score, nan=-np.inf), kind="stable")
    known = [row for row in order if all(int(records["visit"][row]) in tape for tape in tapes.values())]
    for row in known[:most]:
        record = records[row]
        for index, tape in tapes.items():
            actions, played = tape[int(record["visit"])][:MAX_STEPS], int(record["num_played"][index])
            returns = record["returns"][index, :played]
            level = records["level"][row : row + 1].copy()
            numbers = update, int(record["id"]), int(record["visit"])
            replays.append(Replay(*numbers, method.learners[index].name, level, actions, returns))
    return replays


class Played(NamedTuple):
    """The replayed episodes of a level.

    Attributes:
        frames: frames of all episodes in sequence, n + 1 for an episode of n steps: positions `[K, 2]` in meters, or
            images uint8 `[height, width, 3]`; empty without a painter and rendered images.
        begins: index of the first frame of each episode.
        returns: returns of the finished episodes `[n]`, n at most the recorded number.
    """

    frames: list[np.ndarray]
    begins: list[int]
    returns: np.ndarray


class Stage:
    """An environment of size 1 for replaying levels, and its frames.

    Attributes:
        env: the environment.
        painter: returns the points of a frame; None: frames are rendered images, if any.
        step_seconds: time between two frames.
    """

    def __init__(self, env: UPOMDP, painter: ScenePainter | None) -> None:
        self.env, self.painter = env, painter
        self.step_seconds = 1 / (env.metadata.get("render_fps") or 1 / STEP_SECONDS)

    def play(self, replay: Replay) -> Played:
        """Replay a level's episodes."""
        self.env.reset_to_levels(replay.level, None, replay.visit)
        frames, begins, returns, total = [self._frame()], [0], list[float](), 0.0
        for action in replay.actions:
            _, reward, terminated, truncated, _ = self.env.advance(np.asarray(action)[None])  # shows the final state
            total += float(reward[0])
            frames.append(self._frame())
            if terminated[0] or truncated[0]:
                returns.append(total)
                total = 0.0
                if len(returns) == len(replay.returns):
                    break
                self.env.play_again()
                begins.append(len(frames))
                frames.append(self._frame())
        shown = [frame for frame in frames if frame is not None]
        if self.painter is None:
            shown = [fitted(frame, shown[0]) for frame in shown]
        return Played(shown, begins if shown else [], np.array(returns))

    def _frame(self) -> np.ndarray | None:
        """Return a frame of the environment in its current state."""
        if self.painter is not None:
            return self.painter.frame(self.env)
        images = rendered(self.env)
        return None if images is None else images[0]


def came_out_alike(replay: Replay, returns: np.ndarray) -> bool:
    """Return whether replayed episodes reproduce the recorded returns `[n]`, up to the saved actions."""
    whole = len(returns) == len(replay.returns) or len(replay.actions) == MAX_STEPS
    return whole and np.allclose(returns, replay.returns[: len(returns)], atol=1e-6)


def _saved_dtype(dtype: np.dtype) -> np.dtype:
    """Return the dtype of saved actions; int16 suffices for indices of discrete actions."""
    return np.dtype(np.int16) if dtype.kind in "iu" else dtype


def _spell(data: np.ndarray) -> str:
    return base64.b64encode(zlib.compress(data.tobytes(), 6)).decode()


def _read(text: str, most: int) -> bytes:
    data = zlib.decompressobj().decompress(base64.b64decode(text, validate=True), most + 1)
    if len(data) > most:
        raise ValueError(f"it holds more than {most} bytes")
    return data
