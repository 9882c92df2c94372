"""Worker processes that run GRF: each plays some of the episodes of a batch.

Scene, seed and actions determine an episode: GRF replays it bit for bit. If a process dies, hangs or sends an invalid
answer, another process replays its episodes and continues them. Copied and resumed environments replay their episodes
in the same way.

Environments share the processes, which end with the last environment that uses them.
Read next: `grf.worker`, the process.
"""

from __future__ import annotations

import atexit
import itertools
import os
import select
import signal
import subprocess
import tempfile
import time
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from regista.envs.grf import worker
from regista.envs.grf.worker import OBSERVED, PROTOCOL, ROWS, pack, unpack

START_SECONDS = 120.0  # for a new worker to load GRF
ANSWER_SECONDS = 60.0  # s for an answer, plus STEP_SECONDS for each step of the request
STEP_SECONDS = 0.5  # s, on a busy machine
MOST_DEATHS = 3  # maximum deaths of one worker during one request
MOST_ENGINES = 32  # per worker, about 55 MB each, unless one request needs more
LAST_WORDS = 1500  # characters of stderr that an error quotes

HELP = "`make grf` installs it on Debian (docs/howto/real-engine.md); or name its Python by --grf-python or {variable}"
VARIABLE, HOME = "REGISTA_GRF_PYTHON", "REGISTA_GRF_HOME"
DEFAULT_HOME = Path("~/.local/share/regista/grf")


class GrfError(RuntimeError):
    """Google Research Football is not installed, or rejects a request; the message names the remedy."""


class WorkerGoneError(Exception):
    """A worker died, hung, or sent an invalid answer."""


def grf_python(chosen: str | None = None) -> Path:
    """Return the Python that has gfootball: from the config, the environment variable, or `make grf`.

    Raises GrfError if there is none.
    """
    home = Path(os.environ.get(HOME) or DEFAULT_HOME).expanduser()
    path = Path(chosen or os.environ.get(VARIABLE) or home / "bin" / "python").expanduser()
    if not os.access(path, os.X_OK) or path.is_dir():
        raise GrfError(f"Google Research Football is not installed: no {path}. {HELP.format(variable=VARIABLE)}")
    return path


@dataclass(eq=False)
class Episode:
    """One match from its start, with all data needed to replay it.

    `actions` holds the actions of each step, int64 `[22]`. `check` is the checksum of the last observation, which a
    replay must reproduce.
    """

    scene: dict[str, Any]
    seed: int
    actions: list[np.ndarray] = field(default_factory=list)
    check: int | None = None
    slot: int = field(default_factory=itertools.count().__next__)
    life: object = None  # `WorkerProcess.life` of the worker that has the episode in memory


class WorkerProcess:
    """One process, started by the first request. `life` is a new object after each start."""

    def __init__(self, python: Path) -> None:
        self.python = python
        self.process: subprocess.Popen | None = None
        self.life: object = None
        self.held: dict[int, Episode] = {}  # by slot, the most recently played one last
        self.forgotten: list[int] = []  # slots to free with the next request
        self._log: Any = None

    def ask(self, message: dict[str, Any], seconds: float, **arrays: np.ndarray) -> None:
        """Send a request that must be answered within `seconds`. Raises WorkerGoneError."""
        if self.process is None:
            self._start()
        forgotten, self.forgotten = self.forgotten, []
        self._send(message | {"forget": forgotten}, seconds, **arrays)

    def answer(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """Return the answer and its arrays. Raises WorkerGoneError, or GrfError if GRF reports an error."""
        try:
            message, arrays = unpack(self._read)
        except worker.ProtocolError as error:
            raise WorkerGoneError(str(error)) from error
        if "error" in message:
            raise GrfError(f"Google Research Football failed: {message['error'].strip()}")
        return message, arrays

    def hold(self, episodes: Sequence[Episode]) -> None:
        """Mark these episodes as played last; if there are too many engines, free the least recently played ones."""
        for episode in episodes:
            self.held.pop(episode.slot, None)
            self.held[episode.slot] = episode
        while len(self.held) > max(MOST_ENGINES, len(episodes)):
            self.give_up(next(iter(self.held.values())))

    def give_up(self, episode: Episode) -> None:
        """Free the engine of an episode; a later step first replays the episode."""
        if self.held.pop(episode.slot, None) is not None:
            self.forgotten.append(episode.slot)
            episode.life = None

    def kill(self) -> None:
        """End the process at once."""
        process, self.process, self.life = self.process, None, None
        self.held.clear()
        self.forgotten.clear()
        if process is not None:
            with suppress(OSError):  # the whole session: a script may have started Python
                os.killpg(process.pid, signal.SIGKILL)
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                assert pipe is not None
                pipe.close()

    def last_words(self) -> str:
        """Return the last characters that the process has written to stderr."""
        if self._log is None:
            return ""
        self._log.seek(max(self._log.seek(0, os.SEEK_END) - LAST_WORDS, 0))
        return self._log.read().decode(errors="replace").strip()

    def _start(self) -> None:
        self._log = tempfile.TemporaryFile()  # noqa: SIM115 (it lives as long as the process)
        command = [str(self.python), worker.__file__]
        settings = os.environ | {"OMP_NUM_THREADS": "1", "SDL_VIDEODRIVER": "dummy", "PYTHONDONTWRITEBYTECODE": "1"}
        try:
            self.process = subprocess.Popen(
                command,
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._log,
                env=settings,
                start_new_session=True,  # a Ctrl-C is for the parent alone, which closes the worker
            )
        except OSError as error:
            raise GrfError(f"{self.python} cannot be started: {error}") from error
        assert self.process.stdin is not None
        os.set_blocking(self.process.stdin.fileno(), False)  # writes must not block if a hung worker's pipe is full
        self.life = object()
        try:
            self._send({"do": "hello"}, START_SECONDS)
            message, _ = self.answer()
            if message.get("protocol") != PROTOCOL:
                raise GrfError(f"the GRF worker uses protocol version {message.get('protocol')}, expected {PROTOCOL}")
        except BaseException:  # an invalid greeting, or an interrupted wait
            self.kill()
            raise

    def _send(self, message: dict[str, Any], seconds: float, **arrays: np.ndarray) -> None:
        assert self.process is not None and self.process.stdin is not None
        self._until = time.monotonic() + seconds
        data = memoryview(pack(message | {"seconds": seconds}, **arrays))
        try:
            while data:
                if not select.select([], [self.process.stdin], [], max(self._until - time.monotonic(), 0))[1]:
                    raise WorkerGoneError(f"the GRF worker did not accept a request within {seconds:g} s")
                data = data[os.write(self.process.stdin.fileno(), data) :]
        except OSError as error:
            raise WorkerGoneError(f"the GRF worker accepts no requests: {error}") from error

    def _read(self, count: int) -> bytes:
        assert self.process is not None and self.process.stdout is not None
        parts = b""
        while len(parts) < count:
            left = self._until - time.monotonic()
            if left <= 0 or not select.select([self.process.stdout], [], [], left)[0]:
                raise WorkerGoneError("the GRF worker did not answer in time")
            more = os.read(self.process.stdout.fileno(), count - len(parts))
            if not more:
                raise WorkerGoneError("the GRF worker process died")
            parts += more
        return parts


class Workers:
    """A pool of processes; an episode's slot determines its process.

    `begin` and `play` raise GrfError if GRF rejects a request, or if workers die repeatedly during the same request.
    """

    def __init__(self, python: Path, count: int) -> None:
        self.processes = [WorkerProcess(python) for _ in range(count)]
        self._owner = os.getpid()
        self._users = 0  # number of open environments

    def enter(self) -> None:
        """Register one more environment that uses these processes."""
        self._users += 1

    def leave(self) -> None:
        """Unregister an environment; the processes end with the last one."""
        self._users -= 1
        if self._users <= 0:
            self.close()

    def begin(self, episodes: Sequence[Episode]) -> np.ndarray:
        """Start these episodes, or replay their actions so far; return OBSERVED `[K]`."""
        for episode in episodes:
            episode.life = None
        return self._serve(episodes, None)

    def play(self, episodes: Sequence[Episode], actions: np.ndarray) -> np.ndarray:
        """Play a step of each episode with actions `[K, 22]`; return OBSERVED `[K]`."""
        observed = self._serve(episodes, actions)
        for episode, own, seen in zip(episodes, actions, observed, strict=True):
            episode.actions.append(own.copy())
            episode.check = zlib.crc32(seen.tobytes())
        return observed

    def forget(self, episodes: Sequence[Episode]) -> None:
        """Release episodes that are no longer needed."""
        for episode in episodes:
            self._home(episode).give_up(episode)

    def close(self) -> None:
        """End all processes; a later request restarts them. A forked process does not end its parent's workers."""
        for process in self.processes if os.getpid() == self._owner else ():
            process.kill()

    def _home(self, episode: Episode) -> WorkerProcess:
        return self.processes[episode.slot % len(self.processes)]

    def _serve(self, episodes: Sequence[Episode], actions: np.ndarray | None) -> np.ndarray:
        """Execute one request on every worker; retry on failure."""
        observed = np.zeros(len(episodes), OBSERVED)
        waiting: dict[WorkerProcess, list[int]] = {}
        for index, episode in enumerate(episodes):
            waiting.setdefault(self._home(episode), []).append(index)
        try:
            for _ in range(MOST_DEATHS):
                failed = self._bring_back(waiting, episodes, observed)
                if actions is not None:
                    failed |= self._step(waiting, episodes, actions, observed, failed)
                waiting = {process: waiting[process] for process in failed}
                if not waiting:
                    return observed
        except BaseException:  # otherwise the pending answer would be read as that of the next request
            for process in self.processes:
                process.kill()
            raise
        process, reason = next(iter(failed.items()))
        words = process.last_words()
        raise GrfError(
            f"a worker of Google Research Football failed {MOST_DEATHS} times during the same step: {reason}"
            + (f"; its last output: {words}" if words else "")
        )

    def _bring_back(
        self, waiting: dict[WorkerProcess, list[int]], episodes: Sequence[Episode], observed: np.ndarray
    ) -> dict[WorkerProcess, str]:
        """Let workers begin or replay the episodes that they do not hold; return failed workers, with reasons."""
        rounds = _Round()
        for process, indices in waiting.items():
            process.hold([episodes[i] for i in indices])
            lost = [i for i in indices if episodes[i].life is None or episodes[i].life is not process.life]
            if lost:
                rounds.ask(process, lost, *_begin_request([episodes[i] for i in lost]))
        for process, indices, answer in rounds.answers():
            observed[indices] = answer
            for i, seen in zip(indices, answer, strict=True):
                episodes[i].life = process.life
                check_repeated(episodes[i], seen)
        return rounds.failed

    def _step(
        self,
        waiting: dict[WorkerProcess, list[int]],
        episodes: Sequence[Episode],
        actions: np.ndarray,
        observed: np.ndarray,
        failed: dict[WorkerProcess, str],
    ) -> dict[WorkerProcess, str]:
        rounds = _Round()
        for process, indices in waiting.items():
            if process not in failed:
                slots = [episodes[i].slot for i in indices]
                seconds = ANSWER_SECONDS + STEP_SECONDS * len(slots)
                rounds.ask(process, indices, {"do": "step", "slots": slots}, seconds, {"actions": actions[indices]})
        for _, indices, answer in rounds.answers():
            observed[indices] = answer
        return rounds.failed


class _Round:
    """One request to each of several workers, which work in parallel."""

    def __init__(self) -> None:
        self.asked: list[tuple[WorkerProcess, list[int]]] = []
        self.failed: dict[WorkerProcess, str] = {}

    def ask(
        self,
        process: WorkerProcess,
        indices: list[int],
        message: dict[str, Any],
        seconds: float,
        arrays: dict[str, np.ndarray],
    ) -> None:
        try:
            process.ask(message, seconds, **arrays)
            self.asked.append((process, indices))
        except WorkerGoneError as error:
            self._lose(process, error)

    def answers(self) -> Any:
        """Yield process, indices and OBSERVED `[k]` of every worker that answers."""
        for process, indices in self.asked:
            try:
                observed = process.answer()[1].get("observed")
                if observed is None or observed.dtype != OBSERVED or observed.shape != (len(indices),):
                    raise WorkerGoneError("the GRF worker sent an answer to another request")
            except WorkerGoneError as error:
                self._lose(process, error)
            else:
                yield process, indices, observed

    def _lose(self, process: WorkerProcess, error: WorkerGoneError) -> None:
        process.kill()
        self.failed[process] = str(error)


def _begin_request(episodes: Sequence[Episode]) -> tuple[dict[str, Any], float, dict[str, np.ndarray]]:
    """Return the request that begins or replays episodes, its time limit in seconds, and its arrays."""
    lengths = np.array([len(episode.actions) for episode in episodes], np.int64)
    played = [row for episode in episodes for row in episode.actions]
    actions = np.array(played, np.int64).reshape(len(played), ROWS)
    message = {
        "do": "begin",
        "slots": [episode.slot for episode in episodes],
        "scenes": [episode.scene for episode in episodes],
        "seeds": [episode.seed for episode in episodes],
    }
    seconds = ANSWER_SECONDS + STEP_SECONDS * (20 * len(episodes) + len(played))
    return message, seconds, {"lengths": lengths, "actions": actions}


def check_repeated(episode: Episode, seen: np.ndarray) -> None:
    """Raise GrfError if a replayed episode differs from its first play."""
    check = zlib.crc32(seen.tobytes())
    if episode.check is not None and episode.check != check:
        raise GrfError(
            f"Google Research Football did not replay an episode identically (seed {episode.seed}, step "
            f"{len(episode.actions)}): has the installed version changed since it began?"
        )
    episode.check = check


_SHARED: dict[tuple[int, Path, int], Workers] = {}


def shared_workers(python: Path, count: int) -> Workers:
    """Return this process's workers for a Python and a number of workers; all environments share them."""
    key = os.getpid(), python, count  # a forked process has its own workers
    if key not in _SHARED:
        _SHARED[key] = Workers(python, count)
    return _SHARED[key]


@atexit.register
def close_all() -> None:
    """End all workers of this process."""
    for (owner, _, _), workers in _SHARED.items():
        if owner == os.getpid():
            workers.close()
