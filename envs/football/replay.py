"""Records of matches: where they started and what the agents did, from which they are played again bit for bit.

    recorder = Recorder(env)                  # a FootballVectorEnv that has been reset
    recorder.step(actions)                    # in place of env.step
    recorder.save("match.npz")
    for matches in replay("match.npz"):       # MATCH [N] at the start and after every step
        ...

A record is a NumPy archive without pickled objects: reading a stranger's runs nothing of his. Read next: `vector_env`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from regista.envs.football.config import FootballConfig
from regista.envs.football.state import MATCH
from regista.envs.football.vector_env import FootballVectorEnv
from regista.envs.football.version import SIMULATOR_VERSION, UNNUMBERED, simulator_name, version_on
from scenic_lite import ScenicError

KIND = "regista match record"
LARGEST = 2**31  # bytes of a record, unpacked
FORMAT = f"{KIND} 4"  # 3: before episodes had luck of their own
_TEXTS = ("format", "program", "program_file", "config", "np_random")
_STATE = ("matches", "starts", "registers", "start_registers", "minimap_places", "minimap_agents")
_LEVELS = ("levels", "visits", "episodes")
_ARRAYS = ("actions", "last", *_STATE, *_LEVELS)
_OPTIONAL = ("scripted", "lengths", "simulator")  # the first two: of demonstrations; the last: of our own matches


class RecordError(ValueError):
    """A file that is no record of a match, or one that this simulator plays differently; the message says which."""


@dataclass(frozen=True)
class Record:
    """What is in a record.

    Attributes:
        program: the text of the program, and `file`, where it stood ("" if nowhere): a program with modules of its own
            is read from there again.
        config: the settings of the environment.
        state: of the environment at the start, as `get_state` gives it.
        actions: `[T, N]` or `[T, N, A]`.
        last: MATCH `[N]` after the last step.
        scripted: the program played the agents' players; `actions` tells what that was.
        lengths: `[N]` steps of one episode each, after which a match stands still; None: all are played to the end.
    """

    program: str
    file: str
    config: FootballConfig
    state: dict[str, Any]
    actions: np.ndarray
    last: np.ndarray
    scripted: bool = False
    lengths: np.ndarray | None = None

    def rows(self, kept: np.ndarray) -> Record:
        """Return the record of some of the matches, at these indices."""
        matches, size = np.asarray(self.last), len(self.last)
        state = {
            name: value[kept] if isinstance(value, np.ndarray) and len(value) == size else value
            for name, value in self.state.items()
        }
        lengths = None if self.lengths is None else self.lengths[kept]
        steps = len(self.actions) if lengths is None else int(lengths.max(initial=0))
        return replace(self, state=state, actions=self.actions[:steps, kept], last=matches[kept], lengths=lengths)

    def make_env(self) -> FootballVectorEnv:
        """Return the environment as it was at the start. Raises `RecordError` where that is not possible."""
        try:
            path = Path(self.file)
            source: Path | str = path if path.is_file() and path.read_text() == self.program else self.program
        except (OSError, ValueError):  # no path, or no text
            source = self.program
        try:
            env = FootballVectorEnv(source, len(self.last), config=self.config)
            env.scripted = self.scripted
            env.set_state(self.state)
        except (ScenicError, ValueError) as error:
            raise RecordError(f"the record's program cannot be set up again: {error}") from error
        return env


class Recorder:
    """Steps an environment and writes down the actions.

    Raises ValueError for an environment that draws new levels by itself (`level_sampler`), and before its reset.
    """

    def __init__(self, env: FootballVectorEnv) -> None:
        if env.level_sampler is not None:
            raise ValueError("a record needs matches that play their level again; set env.level_sampler = None")
        self.env, self._state = env, env.get_state()
        self._actions: list[np.ndarray] = []
        self._single = False
        self._lengths, self._over = np.zeros(env.num_envs, np.int64), np.zeros(env.num_envs, bool)

    def step(self, actions: Any) -> Any:
        """Step the environment; gives what `env.step` does."""
        result = self.env.step(actions)
        self._actions.append(np.array(actions, np.int64))
        return result

    def advance(self, actions: Any) -> Any:
        """Step the environment and start no match again; gives what `env.advance` does.

        The record is one of single episodes from then on: a match that has ended stands still when it is replayed.
        """
        self.env.idle[:] = self._over
        result = self.env.advance(actions)
        self.env.idle[:] = False
        self._actions.append(np.array(actions, np.int64))
        self._lengths += ~self._over
        self._over |= result[2] | result[3]
        self._single = True
        return result

    def record(self) -> Record:
        """Return the record up to now."""
        shape = self.env.action_space.shape
        assert shape is not None
        actions = np.array(self._actions, np.int64).reshape(len(self._actions), *shape)
        program = self.env.program
        folder = program.mode.state.root  # of a program that was read from a file: its modules lie there
        file = "" if folder is None else str((folder / program.file).resolve())
        lengths = self._lengths if self._single else None
        last = np.asarray(self.env.matches)
        return Record(program.source, file, self.env.config, self._state, actions, last, lengths=lengths)

    def save(self, path: str | Path) -> None:
        """Write the record to a `.npz` file."""
        save_record(self.record(), path)


def save_record(record: Record, path: str | Path | BinaryIO) -> None:
    """Write a record, to an open file or by name. Raises ValueError for a file name that does not end in .npz."""
    if isinstance(path, str | Path) and Path(path).suffix != ".npz":
        raise ValueError(f"{path}: a record ends in .npz")
    texts: dict[str, Any] = {
        "format": FORMAT,
        "program": record.program,
        "program_file": record.file,
        "config": json.dumps(asdict(record.config)),
        "np_random": json.dumps(record.state["np_random"]),
    }
    arrays: dict[str, Any] = {name: value for name, value in record.state.items() if isinstance(value, np.ndarray)}
    if record.lengths is not None:
        arrays["lengths"] = record.lengths
    arrays |= {"scripted": np.array(record.scripted), "actions": record.actions}
    version = version_on(record.config.engine)
    if version is not None:
        arrays["simulator"] = np.array(version)
    np.savez_compressed(path, last=np.asarray(record.last).view(MATCH), **arrays, **texts)


def load_record(path: str | Path) -> Record:
    """Read a record. Raises `RecordError` for a file that is none, that is damaged, or of another version."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            if sum(member.file_size for member in archive.zip.infolist()) > LARGEST:
                raise RecordError(f"{path} is larger than any record: it would be more than {LARGEST:,} bytes")
            arrays = {name: archive[name] for name in archive.files}
    except (FileNotFoundError, PermissionError, IsADirectoryError, RecordError):
        raise
    except Exception as error:  # whatever a damaged archive makes NumPy stumble over
        raise RecordError(f"{path} is no record of a match, or it is damaged") from error
    stated = str(arrays.get("format"))
    if not stated.startswith(KIND):
        raise RecordError(f"{path} is no record of a match: it does not say {KIND!r}")
    if stated != FORMAT:
        raise RecordError(f"{path} has another format: it is a {stated}, not {FORMAT[-1]}")
    missing = [name for name in (*_TEXTS, *_ARRAYS) if name not in arrays]
    if missing:
        raise RecordError(f"{path} is damaged: {', '.join(missing)} missing")
    try:
        version = _version(arrays)
        if version not in (None, SIMULATOR_VERSION):
            found = simulator_name(version)
            raise RecordError(f"{path} was recorded on {found}; version {SIMULATOR_VERSION} cannot replay it")
        if arrays["last"].dtype != MATCH or arrays["matches"].dtype != MATCH:
            raise RecordError(f"{path} was recorded by other code: its matches have other fields")
        return _decoded(arrays)
    except RecordError:
        raise
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise RecordError(f"{path} is damaged: {error}") from error


def _version(arrays: dict[str, np.ndarray]) -> int | None:
    """Return the version of the simulator that a record is of, None of one of the real engine."""
    ours = version_on(json.loads(str(arrays["config"]))["engine"]) is not None
    return int(arrays.get("simulator", UNNUMBERED)) if ours else None


def _decoded(arrays: dict[str, Any]) -> Record:
    """Return the record that these arrays are. Raises ValueError or TypeError where they do not fit together."""
    program, file, config, random = (str(arrays[name]) for name in ("program", "program_file", "config", "np_random"))
    actions, lengths, count = arrays["actions"], arrays.get("lengths"), len(np.atleast_1d(arrays["last"]))
    if arrays["last"].shape != (count,) or not count:
        raise ValueError("it has no matches")
    if actions.dtype.kind not in "iu" or actions.shape[1:2] != (count,):
        raise ValueError(f"actions must be whole numbers for each of {count} matches")
    if lengths is not None and (
        lengths.dtype.kind not in "iu" or lengths.shape != (count,) or lengths.min() < 0 or lengths.max() > len(actions)
    ):
        raise ValueError(f"lengths must be 0 to {len(actions)} steps for each of {count} matches")
    state = {name: array for name, array in arrays.items() if name not in (*_TEXTS, *_OPTIONAL, "actions", "last")}
    state["np_random"] = json.loads(random)
    # Which program on this machine plays is no business of whoever recorded the matches.
    settings = FootballConfig(**json.loads(config) | {"grf_python": None, "grf_workers": 0})  # of this machine
    scripted = bool(np.all(arrays.get("scripted", False)))
    return Record(program, file, settings, state, actions, arrays["last"], scripted, lengths)


def replay(record: Record | str | Path, *, endings: bool = False) -> Iterator[np.ndarray]:
    """Play a record again: gives MATCH `[N]` at the start and after each of the T steps.

    With `endings` those that ended in a step are given as they ended, otherwise as they have started again. Raises
    `RecordError` as `load_record`, and at the end if the matches came out differently than when recorded.
    """
    record = record if isinstance(record, Record) else load_record(record)
    env = record.make_env()
    yield env.matches
    for step, actions in enumerate(record.actions):
        if record.lengths is not None:
            env.idle[:] = record.lengths <= step
        try:
            _, _, terminated, truncated, _ = env.advance(actions)
        except ValueError as error:
            raise RecordError(f"the record is damaged: {error}") from error
        if endings:
            yield env.matches
        ended = (terminated | truncated) & (record.lengths is None)
        if ended.any():
            env.play_again(ended)
        if not endings:
            yield env.matches
    if not same(env.matches, record.last):  # where an episode has ended, the next one's start
        raise RecordError(
            "the matches came out differently than when they were recorded: the mathematical functions of another "
            "machine can round otherwise"
        )


def same(first: np.ndarray, second: np.ndarray) -> bool:
    """Return whether two batches of matches are equal field by field, bit for bit."""
    return bool((np.asarray(first).view(MATCH) == np.asarray(second).view(MATCH)).all())
