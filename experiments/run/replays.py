"""The very episodes that made a level's score, as a table of a run, and how they are played again.

A row is a level with its seed and what a student did on it; an environment that is put on that level and is given these
actions plays the same episodes, whatever has become of the student since. Read next: `ued.learning.tape`.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from regista.experiments.run.errors import CommandError
from ued.core.level_space import level_dtype
from ued.core.painter import ScenePainter
from ued.core.upomdp import UPOMDP

MAX_STEPS = 2_000  # of the episodes on one level
STEP_SECONDS = 0.1  # of an environment that says nothing of it


@dataclass(frozen=True)
class Replay:
    """What a student did on a level, in all of its episodes there.

    Attributes:
        update, id, visit: of the update that was based on the level, of the level, and of this playing of it.
        student: whose episodes they are.
        level: the level, a record of `level_dtype(D)` `[1]`; `visit` is the number of this visit of it.
        actions: `[T, ...]`, as the environment was given them.
        returns: of its episodes `[n]`, as they were.
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
            "returns": " ".join(f"{value:g}" for value in self.returns),
            "level": _spell(self.level),
            "actions": _spell(self.actions.astype(_kept(self.actions.dtype))),
        }

    @classmethod
    def of_row(cls, row: Mapping[str, str], upomdp: Any) -> Replay:
        """Read a row of replays.csv, of these environments. Raises `CommandError` for one that is damaged."""
        dtype, space = level_dtype(upomdp.theta_dim), upomdp.single_action_space
        try:
            level = np.frombuffer(_read(row["level"], dtype.itemsize), dtype).reshape(1)
            kept = _kept(space.dtype)
            data = _read(row["actions"], MAX_STEPS * max(int(np.prod(space.shape)), 1) * kept.itemsize)
            actions = np.frombuffer(data, kept).astype(space.dtype).reshape(-1, *space.shape)
            returns = np.array(row["returns"].split(), float)
            update, number, visit = (int(row[name]) for name in ("update", "id", "visit"))
            return cls(update, number, visit, row["student"], level, actions, returns)
        except (ValueError, KeyError, zlib.error) as error:
            raise CommandError(f"a row of replays.csv is damaged: {error}") from error


def taken(method: Any, update: int, most: int) -> list[Replay]:
    """Return what all students did on the levels of the highest scores of the last update, at most so many levels.

    Levels of which not everything is known, because they were begun before a kill, are left out.
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
    """A level's episodes, played again.

    Attributes:
        frames: of all, one after the other: places `[K, 2]` in metres, or images uint8 `[height, width, 3]`; none where
            nothing can be shown.
        begins: which of these each episode begins with.
        returns: of the episodes that came to their end `[n]`, n at most as many as there were.
    """

    frames: list[np.ndarray]
    begins: list[int]
    returns: np.ndarray


class Stage:
    """An environment of one in which levels are played again, and what is shown of it.

    Attributes:
        env: the environment.
        painter: tells its points; None: it is shown as it renders itself, if it does.
        step_seconds: between two frames.
    """

    def __init__(self, env: UPOMDP, painter: ScenePainter | None) -> None:
        self.env, self.painter = env, painter
        self.step_seconds = 1 / (env.metadata.get("render_fps") or 1 / STEP_SECONDS)

    def play(self, replay: Replay) -> Played:
        """Play a level's episodes again."""
        self.env.reset_to_levels(replay.level, None, replay.visit)
        frames, begins, returns, total = [self._frame()], [0], list[float](), 0.0
        for action in replay.actions:
            _, reward, terminated, truncated, _ = self.env.step(np.asarray(action)[None])
            total += float(reward[0])
            if terminated[0] or truncated[0]:
                returns.append(total)
                total = 0.0
                if len(returns) == len(replay.returns):
                    break
                begins.append(len(frames))
            frames.append(self._frame())
        shown = [frame for frame in frames if frame is not None]
        return Played(shown, begins if shown else [], np.array(returns))

    def _frame(self) -> np.ndarray | None:
        """Return what is shown of the environment as it stands."""
        if self.painter is not None:
            return self.painter.frame(self.env)
        images: Any = self.env.render() if self.env.render_mode == "rgb_array" else None
        return None if images is None else np.asarray(images[0], np.uint8)


def came_out_alike(replay: Replay, returns: np.ndarray) -> bool:
    """Return whether episodes that were played again brought the returns `[n]` that they had."""
    return len(returns) == len(replay.returns) and np.allclose(returns, replay.returns, atol=1e-6)


def _kept(dtype: np.dtype) -> np.dtype:
    """Return how actions are kept: the numbers of choices are small."""
    return np.dtype(np.int16) if dtype.kind in "iu" else dtype


def _spell(data: np.ndarray) -> str:
    return base64.b64encode(zlib.compress(data.tobytes(), 6)).decode()


def _read(text: str, most: int) -> bytes:
    data = zlib.decompressobj().decompress(base64.b64decode(text, validate=True), most + 1)
    if len(data) > most:
        raise ValueError(f"it holds more than {most} bytes")
    return data
