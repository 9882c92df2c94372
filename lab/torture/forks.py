"""Run hundreds of commands: a process with all imports done forks for each, and reports how it ended.

A forked command begins in milliseconds, so that faults and signals hit its own work. It runs in a fresh process, and so
do the processes that it starts; `faults.c` is loaded before libc. The server adopts orphaned processes of commands.
"""

from __future__ import annotations

import atexit
import ctypes
import json
import multiprocessing
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

from tests.attacks.files import TASK, undrawn
from tests.envs.grf.fixtures import fake_python

ROOT = Path(__file__).resolve().parents[2]
KINDS = ("full", "broken", "killed", "torn")  # as in faults.c, from 1
NEVER = 10**9  # a change number that no command reaches
PATIENCE = 120.0  # s from the signal to the end, and for processes that a command started
HUNG = -1_000  # the exit code of a command that did not end; no valid exit code
SUBREAPER = 36  # PR_SET_CHILD_SUBREAPER of prctl


@dataclass(frozen=True)
class Order:
    """A command, and the fault or signal that it meets.

    Attributes:
        words: arguments of `regista`.
        root: the folder in which changes are counted.
        at: the number of the change that meets the fault.
        kind: one of `KINDS`: no space left from there on; one I/O error; killed before the change; killed during it.
        seconds: time until `number` is sent; None: never.
        number: a signal.
        all: send it to all processes of the command, not to the command alone.
    """

    words: list[str]
    root: str
    at: int = NEVER
    kind: str = KINDS[0]
    seconds: float | None = None
    number: int = signal.SIGKILL
    all: bool = False


class End(NamedTuple):
    """The end of a command: exit code, -n for signal n; output; changes counted; seconds; processes left behind."""

    code: int
    said: str
    changes: int
    seconds: float
    left: int


class Forks:
    """The client side of the server."""

    def __init__(self, folder: Path) -> None:
        library = folder / "faults.so"
        source = Path(__file__).with_name("faults.c")
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", str(library), str(source), "-ldl"], check=True)
        environment = os.environ | {"LD_PRELOAD": str(library), "NUMBA_THREADING_LAYER": "workqueue"}
        environment["REGISTA_GRF_PYTHON"] = str(fake_python(folder))  # stands in for the GRF interpreter
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        words = [sys.executable, "-m", "lab.torture.forks", str(folder)]
        self.process = subprocess.Popen(words, env=environment, cwd=ROOT, **pipes)
        atexit.register(self.close)

    def run(self, order: Order) -> End:
        """Run a command."""
        assert self.process.stdin is not None and self.process.stdout is not None
        print(json.dumps(asdict(order)), file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        assert answer, "the server of forks has ended"
        return End(*json.loads(answer))

    def close(self) -> None:
        """End the server."""
        with suppress(OSError):
            self.process.stdin.close()  # type: ignore[union-attr]
        self.process.wait()


# ---------------------------------------------------------------- the server


class Forked:
    """Replaces `subprocess.Popen` in `run.launch.workers`: forks a command of ours instead of starting a new Python."""

    def __init__(self, command: list[str], stdout: Any, stderr: Any, env: dict[str, str], **_: Any) -> None:
        self.returncode: int | None = None
        self.pid = os.fork()
        if self.pid == 0:
            os.environ.update(env)
            os.dup2(stdout.fileno(), 1), os.dup2(stderr.fileno(), 2)
            signal.pthread_sigmask(signal.SIG_SETMASK, [])
            perform(command[3:])

    def poll(self) -> int | None:
        """Return the exit code of a process that has ended."""
        return self._wait(os.WNOHANG)

    def wait(self) -> int | None:
        """Wait for the end of the process."""
        return self._wait(0)

    def _wait(self, flags: int) -> int | None:
        if self.returncode is None:
            pid, status = os.waitpid(self.pid, flags)
            self.returncode = os.waitstatus_to_exitcode(status) if pid else None
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send the process a signal."""
        if self.poll() is None:
            os.kill(self.pid, number)


def perform(words: list[str], begun: int | None = None) -> None:
    """Run a command in this process as in a newly started one; never return."""
    from regista.experiments.__main__ import main

    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL), signal.signal(signal.SIGHUP, signal.SIG_DFL)
    sys.argv = ["regista", *words]
    code = 1
    try:
        if begun is not None:
            tell(begun)
        code = main()
        atexit._run_exitfuncs()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:
        traceback.print_exc()
    finally:
        with suppress(OSError):
            sys.stdout.flush(), sys.stderr.flush()
        os._exit(code)


def tell(begun: int) -> None:
    """Have a byte written when signal handlers are installed; an earlier signal would end Python itself."""
    from regista.experiments.run import errors

    hearing = errors.interruptible

    @contextmanager
    def told(for_good: bool = False) -> Iterator[list[int]]:
        with hearing(for_good) as heard:
            errors.interruptible = hearing
            os.write(begun, b"!")
            yield heard

    errors.interruptible = told


def prepare(folder: Path) -> None:
    """Import the modules of all commands, without starting anything that a fork would lose."""
    import importlib

    from regista.experiments.__main__ import COMMANDS
    from regista.experiments.run.launch import workers

    for name in ("h5py", "minari", "rerun"):
        importlib.import_module(name)
    for name in COMMANDS:
        importlib.import_module(f"regista.experiments.commands.{name}")
    workers.subprocess = SimpleNamespace(Popen=Forked)  # type: ignore[assignment]
    workers.POLL_SECONDS = 0.02
    forked = multiprocessing.get_context("fork")
    workers.multiprocessing = SimpleNamespace(  # type: ignore[assignment]
        get_context=lambda kind: forked, active_children=multiprocessing.active_children
    )
    warm_up(folder, TASK)


@cache
def warm_up(folder: Path, game: str) -> None:
    """Train briefly in this process, so that every fork inherits the loaded and compiled code."""
    from regista.experiments.__main__ import main

    tiny = ["--num-envs", "2", "--num-steps", "8", "--total-env-steps", "16", "--eval-episodes", "2", "--no-record"]
    with tempfile.TemporaryDirectory(dir=folder) as out:
        main(["train", game, "--method", "plr", *tiny, "--out", f"{out}/run"])


def serve(folder: Path) -> None:
    """Answer orders, one line of JSON each, until the input ends."""
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    ctypes.CDLL(None).prctl(SUBREAPER, 1)
    with undrawn():
        prepare(folder)
        for line in sys.stdin:
            if "1v1Restricted" in line:
                warm_up(folder, "1v1Restricted")
            print(json.dumps(carry_out(Order(**json.loads(line)))), file=answers, flush=True)


def carry_out(order: Order) -> End:
    """Fork for a command, and wait for its end."""
    library = ctypes.CDLL(None)
    library.fault_arm(order.root.encode(), order.at, 1 + KINDS.index(order.kind))
    library.fault_count.restype = ctypes.c_long
    reader, writer = os.pipe()
    with tempfile.TemporaryFile() as said:
        pid = os.fork()
        if pid == 0:
            sys.stdin.close(), os.close(reader)
            os.dup2(said.fileno(), 1), os.dup2(said.fileno(), 2)
            perform(order.words, writer)
        os.close(writer)
        os.read(reader, 1), os.close(reader)
        code, seconds = watched(pid, order)
        left, changes = bereaved(), library.fault_count()
        library.fault_arm(b"", -1, 0)
        said.seek(0)
        return End(code, said.read().decode(errors="replace"), changes, seconds, left)


def watched(pid: int, order: Order) -> tuple[int, float]:
    """Wait for a command, and send it its signal; return its exit code and its time in s."""
    began, handle = time.monotonic(), os.pidfd_open(pid)
    if order.seconds is not None and not select.select([handle], [], [], order.seconds)[0]:
        for each in family() if order.all else [pid]:
            with suppress(OSError):
                os.kill(each, order.number)
    if not select.select([handle], [], [], 5 * PATIENCE if order.seconds is None else PATIENCE)[0]:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        os.close(handle)
        return HUNG, time.monotonic() - began
    os.close(handle)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), time.monotonic() - began


def family() -> list[int]:
    """Return all descendants of this process."""
    parents = {}
    for folder in Path("/proc").iterdir():
        if folder.name.isdecimal():
            with suppress(OSError):
                parents[int(folder.name)] = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
    descended = [os.getpid()]
    for process in descended:
        descended += [pid for pid, parent in parents.items() if parent == process]
    return descended[1:]


def bereaved() -> int:
    """Wait for the adopted processes of a command; return how many had to be killed."""
    late, killed = time.monotonic() + PATIENCE, 0
    while True:
        try:
            if os.waitpid(-1, os.WNOHANG)[0]:
                continue
        except ChildProcessError:
            return killed
        if time.monotonic() > late:
            for each in family():
                killed += 1
                os.kill(each, signal.SIGKILL)
            late = time.monotonic() + PATIENCE
        time.sleep(0.01)


if __name__ == "__main__":
    serve(Path(sys.argv[1]))
