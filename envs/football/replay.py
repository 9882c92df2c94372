"""Records of matches: initial states and the agents' actions, enough to replay the matches bit for bit.

    recorder = Recorder(env)                  # a FootballVectorEnv that has been reset
    recorder.step(actions)                    # in place of env.step
    recorder.save("match.npz")
    for matches in replay("match.npz"):       # MATCH [N] at the start and after every step
        ...

A record is a NumPy archive without pickled objects, so loading an untrusted record runs no code from it. Read next:
`vector_env`.
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
LARGEST = 2**31  # maximum bytes of a record, uncompressed
FORMAT = f"{KIND} 4"
MIXED = "a record holds whole matches, by step(), or one episode of each, by advance(); make another Recorder(env)"
_TEXTS = ("format", "program", "program_file", "config", "np_random")
_STATE = ("matches", "starts", "registers", "start_registers", "minimap_places", "minimap_agents")
_LEVELS = ("levels", "visits", "episodes")
_ARRAYS = ("actions", "last", *_STATE, *_LEVELS)
_OPTIONAL = ("scripted", "lengths", "simulator")  # the first two only for demonstrations, the last not for GRF


class RecordError(ValueError):
    """A file that is not a record of a match, or that this simulator plays differently; the message says which."""


@dataclass(frozen=True)
class Record:
    """The content of a record.

    Attributes:
        program: the text of the program; `file`: its path ("" if none), to reload a program that imports modules of its
            own.
        config: the settings of the environment.
        state: the environment's initial state, as `get_state` returns it.
        actions: `[T, N]` or `[T, N, A]`.
        last: MATCH `[N]` after the last step.
        scripted: the program played the agents' players; `actions` holds its actions.
        lengths: `[N]`, steps of each match's single episode, after which it is idle; None: every match plays all steps.
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
        """Return the record of the matches at these indices."""
        matches, size = np.asarray(self.last), len(self.last)
        state = {
            name: value[kept] if isinstance(value, np.ndarray) and len(value) == size else value
            for name, value in self.state.items()
        }
        lengths = None if self.lengths is None else self.lengths[kept]
        steps = len(self.actions) if lengths is None else int(lengths.max(initial=0))
        return replace(self, state=state, actions=self.actions[:steps, kept], last=matches[kept], lengths=lengths)

    def make_env(self) -> FootballVectorEnv:
        """Return the environment in its initial state. Raises `RecordError` if the program cannot be loaded."""
        try:
            path = Path(self.file)
            source: Path | str = path if path.is_file() and path.read_text() == self.program else self.program
        except (OSError, ValueError):  # not a path, or not text
            source = self.program
        try:
            env = FootballVectorEnv(source, len(self.last), config=self.config)
            env.scripted = self.scripted
            env.set_state(self.state)
        except (ScenicError, ValueError) as error:
            raise RecordError(f"cannot load the record's program: {error}") from error
        return env


class Recorder:
    """Steps an environment and records the actions. Use either `step` or `advance`, not both.

    Raises ValueError for an environment that samples new levels by itself (`level_sampler`), or that is not reset.
    """

    def __init__(self, env: FootballVectorEnv) -> None:
        if env.level_sampler is not None:
            raise ValueError("a record needs matches that play their level again; set env.level_sampler = None")
        if not env.matches["num_players"].all():
            raise ValueError("a record begins with matches under way; call env.reset() before Recorder(env)")
        self.env, self._state = env, env.get_state()
        self._actions: list[np.ndarray] = []
        self._single = False
        self._lengths, self._over = np.zeros(env.num_envs, np.int64), np.zeros(env.num_envs, bool)

    def step(self, actions: Any) -> Any:
        """Step the environment; return the result of `env.step`. Raises ValueError after `advance`."""
        if self._single:
            raise ValueError(MIXED)
        result = self.env.step(actions)
        self._note(actions, result[4])
        return result

    def advance(self, actions: Any) -> Any:
        """Step the environment without restarting ended matches; return the result of `env.advance`.

        The record has one episode per match: an ended match is idle in the replay. Raises ValueError after `step`.
        """
        if self._actions and not self._single:
            raise ValueError(MIXED)
        self.env.idle[:] = self._over
        result = self.env.advance(actions)
        self.env.idle[:] = False
        self._note(actions, result[4])
        self._lengths += ~self._over
        self._over |= result[2] | result[3]
        self._single = True
        return result

    def _note(self, actions: Any, info: dict[str, Any]) -> None:
        """Store the actions of a step; if the program plays the agents' players, the program's actions."""
        self._actions.append(np.array(info["agent_actions"] if self.env.scripted else actions, np.int64))

    def record(self) -> Record:
        """Return the record so far."""
        shape = self.env.action_space.shape
        assert shape is not None
        actions = np.array(self._actions, np.int64).reshape(len(self._actions), *shape)
        program = self.env.program
        folder = program.mode.state.root  # the folder of a program loaded from a file, which holds its modules
        file = "" if folder is None else str((folder / program.file).resolve())
        lengths = self._lengths if self._single else None
        last = np.asarray(self.env.matches)
        return Record(program.source, file, self.env.config, self._state, actions, last, self.env.scripted, lengths)

    def save(self, path: str | Path) -> None:
        """Write the record to a `.npz` file."""
        save_record(self.record(), path)


def save_record(record: Record, path: str | Path | BinaryIO) -> None:
    """Write a record to an open file or by name. Raises ValueError for a file name that does not end in .npz."""
    if isinstance(path, str | Path) and Path(path).suffix != ".npz":
        raise ValueError(f"{path}: the name of a record must end in .npz")
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
    """Read a record. Raises `RecordError` for a file that is not a record, is damaged, or has another version."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            if sum(member.file_size for member in archive.zip.infolist()) > LARGEST:
                raise RecordError(f"{path} is too large for a record: its uncompressed size is above {LARGEST:,} bytes")
            arrays = {name: archive[name] for name in archive.files}
    except (FileNotFoundError, PermissionError, IsADirectoryError, RecordError):
        raise
    except Exception as error:  # a damaged archive may cause any exception in NumPy
        raise RecordError(f"{path} is not a record of a match, or it is damaged") from error
    stated = str(arrays.get("format"))
    if not stated.startswith(KIND):
        raise RecordError(f"{path} is not a record of a match: its format is not {KIND!r}")
    if stated != FORMAT:
        raise RecordError(f"{path} has another format: {stated}, expected {FORMAT[-1]}")
    missing = [name for name in (*_TEXTS, *_ARRAYS) if name not in arrays]
    if missing:
        raise RecordError(f"{path} is damaged: {', '.join(missing)} missing")
    try:
        version = _version(arrays)
        if version not in (None, SIMULATOR_VERSION):
            found = simulator_name(version)
            raise RecordError(f"{path} was recorded on {found}; version {SIMULATOR_VERSION} cannot replay it")
        if arrays["last"].dtype != MATCH or arrays["matches"].dtype != MATCH:
            raise RecordError(f"{path} was recorded by another version of the code: its matches have other fields")
        return _decoded(arrays)
    except RecordError:
        raise
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise RecordError(f"{path} is damaged: {error}") from error


def _version(arrays: dict[str, np.ndarray]) -> int | None:
    """Return the simulator version of a record, None for a record of GRF."""
    ours = version_on(json.loads(str(arrays["config"]))["engine"]) is not None
    return int(arrays.get("simulator", UNNUMBERED)) if ours else None


def _decoded(arrays: dict[str, Any]) -> Record:
    """Return the record in these arrays. Raises ValueError or TypeError if they are inconsistent."""
    program, file, config, random = (str(arrays[name]) for name in ("program", "program_file", "config", "np_random"))
    actions, lengths, count = arrays["actions"], arrays.get("lengths"), len(np.atleast_1d(arrays["last"]))
    if arrays["last"].shape != (count,) or not count:
        raise ValueError("the record has no matches")
    if actions.dtype.kind not in "iu" or actions.shape[1:2] != (count,):
        raise ValueError(f"actions must be whole numbers for each of {count} matches")
    if lengths is not None and (
        lengths.dtype.kind not in "iu" or lengths.shape != (count,) or lengths.min() < 0 or lengths.max() > len(actions)
    ):
        raise ValueError(f"lengths must be 0 to {len(actions)} steps for each of {count} matches")
    state = {name: array for name, array in arrays.items() if name not in (*_TEXTS, *_OPTIONAL, "actions", "last")}
    state["np_random"] = json.loads(random)
    # The sender of a record must not choose which Python runs on this machine.
    settings = FootballConfig(**json.loads(config) | {"grf_python": None, "grf_workers": 0})  # the local settings
    scripted = bool(np.all(arrays.get("scripted", False)))
    return Record(program, file, settings, state, actions, arrays["last"], scripted, lengths)


def replay(record: Record | str | Path, *, endings: bool = False) -> Iterator[np.ndarray]:
    """Replay a record: yield MATCH `[N]` at the start and after each of the T steps.

    With `endings`, matches that ended in a step are yielded in their final state, otherwise after their restart. Raises
    `RecordError` as `load_record`, and at the end if the final matches differ from the recorded ones.
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
    if not same(env.matches, record.last):  # the final state, or the start of the next episode
        raise RecordError(
            "the replayed matches differ from the recorded ones: the mathematical functions of another "
            "machine can round differently"
        )


def same(first: np.ndarray, second: np.ndarray) -> bool:
    """Return whether two batches of matches are equal field by field, bit for bit."""
    return bool((np.asarray(first).view(MATCH) == np.asarray(second).view(MATCH)).all())
