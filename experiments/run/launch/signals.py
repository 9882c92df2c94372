"""External reasons for a command to end: Ctrl-C, SIGTERM, a closed terminal, a closed pipe, a dead parent.

By default a command ends at once (`interruptible`); a command with state to save treats the signal as a request
(`StopRequest`). Both print one line, exit with 128 + the signal's number, and leave no child processes.
If the main thread is blocked, `Watchdog` ends the process some seconds after the signal. Files are replaced atomically,
so finished files stay intact, and a resumed run continues from its last checkpoint.
Read next: `run.errors`, which ends every command; `commands.train`.
"""

from __future__ import annotations

import errno
import os
import select
import signal
import sys
import termios
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

from ued.core.processes import end_with_parent

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
WORDS: dict[int, str] = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated", signal.SIGHUP: "hung up"}
# Grace period after a signal, before the process is ended. A run started by another command, which forwards the signal,
# gets less time, so that it ends before its parent.
GRACE_SECONDS, CHILD_GRACE_SECONDS = 8.0, 6.0
PARENT = "REGISTA_PARENT"  # environment variable: the parent process with which a run must end


_is_child = False  # whether another Regista command started this process


class Stopped(KeyboardInterrupt):
    """A signal ended the command: `number` is the signal."""

    def __init__(self, number: int) -> None:
        super().__init__(WORDS[number])
        self.number = number


class Watchdog:
    """While entered, a signal ends the process after a grace period, unless the context ends first.

    A Python signal handler runs only after the main thread returns from a C call. So the C handler also writes the
    number of the signal to a pipe, which a thread reads.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._old = -1
        self._pipe: tuple[int, int] | None = None

    def __enter__(self) -> Watchdog:
        reading, writing = os.pipe()
        os.set_blocking(writing, False)
        try:
            self._old = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
        except ValueError:  # only the main thread receives signals
            os.close(reading)
            os.close(writing)
            return self
        self._pipe = reading, writing
        self._thread = threading.Thread(target=self._watch, args=(reading,), daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._pipe is None:
            return
        reading, writing = self._pipe
        signal.set_wakeup_fd(self._old)
        os.close(writing)  # the thread reads the end of the pipe
        self._thread.join()
        os.close(reading)

    def _watch(self, reading: int) -> None:
        received = None
        while received is None:
            number = os.read(reading, 1)
            if not number:
                return
            received = number[0] if number[0] in SIGNALS else None
        until = time.monotonic() + self.seconds
        while (left := until - time.monotonic()) > 0:
            if select.select([reading], [], [], left)[0] and not os.read(reading, 1):
                return
        _say(WORDS[received])
        _leave(received)


_fork = threading.local()  # signals blocked by the forking thread


def _hold_signals() -> None:
    """Block signals between a fork and `_forget_pipe`, as they would reach the pipe of the parent process."""
    _fork.blocked = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)


def _release_signals() -> None:
    signal.pthread_sigmask(signal.SIG_SETMASK, _fork.blocked)


def _forget_pipe() -> None:
    """Detach a forked process from the pipe, so that its signals do not reach the parent.

    SIGTERM ends it at once: a vector environment ends its workers so, and our handlers would raise an error in them.
    """
    with suppress(ValueError):
        signal.set_wakeup_fd(-1)
        if getattr(signal.getsignal(signal.SIGTERM), "__module__", None) == __name__:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _release_signals()


os.register_at_fork(before=_hold_signals, after_in_parent=_release_signals, after_in_child=_forget_pipe)


def _say(word: str) -> None:
    """Write a last line to stderr; ignore errors."""
    with suppress(OSError):
        if select.select([], [2], [], 0)[1]:
            os.write(2, f"regista: {word}\n".encode())


def watchdog() -> Watchdog:
    """Return the watchdog of a command; its grace period is shorter in a child of another command."""
    return Watchdog(CHILD_GRACE_SECONDS if _is_child else GRACE_SECONDS)


@contextmanager
def interruptible(for_good: bool = False) -> Iterator[list[int]]:
    """Make a signal raise `Stopped` inside, and a second one end the process; `for_good`: also after the context.

    Yields the received signals, since cleanup code may replace `Stopped` by another error.
    """
    heard: list[int] = []
    watching = watchdog()
    hook = sys.unraisablehook
    sys.unraisablehook = lambda broken: _lost(broken.exc_value) if heard else hook(broken)

    def stop(number: int, frame: FrameType | None) -> None:
        heard.append(number)
        _stop(number, frame)

    watching.__enter__()
    try:
        with _handled(stop):
            yield heard
    finally:
        if not (for_good and heard):  # the error deletes interrupted objects, whose destructors may raise
            sys.unraisablehook = hook
        if for_good:  # cleanup at the end of the process is watched too
            with suppress(ValueError):  # no handlers are set in other threads
                _listen(_leave)
        else:
            watching.__exit__()


def _stop(number: int, _: FrameType | None) -> None:
    """Raise `Stopped`; cleanup has a grace period, see `Watchdog`."""
    _listen(_leave)
    if number == signal.SIGHUP:
        forget_terminal()
    raise Stopped(number)


def _lost(error: BaseException | None) -> None:
    """End the process if `Stopped` was raised where Python ignores exceptions, so that it would be lost."""
    if isinstance(error, Stopped):
        _say(WORDS[error.number])
        _leave(error.number)


def _leave(number: int = signal.SIGINT, _: FrameType | None = None) -> None:
    """End the process at once."""
    os._exit(128 + (number if number in SIGNALS else signal.SIGINT))


def _listen(handler: Callable[[int, FrameType | None], Any]) -> dict[int, Any]:
    """Handle the signals except those ignored by the parent (nohup); return the previous handlers."""
    before: dict[int, Any] = {number: signal.getsignal(number) for number in SIGNALS}
    before = {number: handler for number, handler in before.items() if handler != signal.SIG_IGN}
    for number in before:
        signal.signal(number, handler)
    return before


@contextmanager
def _handled(handler: Callable[[int, FrameType | None], Any]) -> Iterator[None]:
    """Handle the signals inside the context; do nothing outside the main thread, which cannot set handlers."""
    try:
        before = _listen(handler)
    except ValueError:
        before = {}
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)


@contextmanager
def held_back() -> Iterator[None]:
    """Defer Ctrl-C until the context ends; processes started inside ignore it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def forget_terminal() -> None:
    """Redirect output to the null device, since the terminal or the reader of the pipe is gone."""
    with suppress(OSError), open(os.devnull, "w") as nowhere:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                os.dup2(nowhere.fileno(), stream.fileno())


def hung_up() -> bool:
    """Return whether the terminal of stdout or stderr is gone; an I/O error alone may also come from a disk."""
    for number in (1, 2):
        try:
            termios.tcgetattr(number)
        except termios.error as error:
            if error.args[0] == errno.EIO:
                return True
    return False


def end_with(parent: int) -> None:
    """Make the kernel send SIGTERM to this process when its parent ends. Linux only."""
    global _is_child
    _is_child = True
    end_with_parent(signal.SIGTERM)
    if sys.platform == "linux" and os.getppid() != parent:  # the parent has already ended
        signal.raise_signal(signal.SIGTERM)


class StopRequest:
    """While entered, the first signal only sets `signal`, so work can finish. A second Ctrl-C raises `Stopped`."""

    def __init__(self) -> None:
        self.signal: int | None = None
        self._entered: list[Any] = []

    def __enter__(self) -> StopRequest:
        self._entered.append(_handled(self._ask))
        self._entered[-1].__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._entered.pop().__exit__(None, None, None)

    def __bool__(self) -> bool:
        return self.signal is not None

    @property
    def exit_code(self) -> int:
        """The exit code: 130 after Ctrl-C, 143 after SIGTERM, 129 after the terminal was closed, 0 without a signal."""
        return 0 if self.signal is None else 128 + self.signal

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self.signal is not None and number == signal.SIGINT:
            _stop(number, frame)
        if number == signal.SIGHUP:
            forget_terminal()
        self.signal = self.signal or number
