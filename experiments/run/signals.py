"""What ends a command from outside: Ctrl-C, SIGTERM, a closed terminal, a reader that has gone, a parent that died.

A command that does not say otherwise ends where it is (`interruptible`); one that has something to save takes the
signal as a request (`StopRequest`). Either way it is one line and 128 + the signal's number, and nobody is left behind.
Read next: `run.errors`, which ends every command; `commands.train`.
"""

from __future__ import annotations

import ctypes
import errno
import os
import signal
import sys
import termios
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
WORDS: dict[int, str] = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated", signal.SIGHUP: "hung up"}
GRACE_SECONDS = 10.0  # in which what was interrupted tidies up; then the process ends anyway
DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl
PARENT = "REGISTA_PARENT"  # in the environment of a run: the process with which it is to end


class Stopped(KeyboardInterrupt):
    """Somebody wants the command to end: `number` is the signal."""

    def __init__(self, number: int) -> None:
        super().__init__(WORDS[number])
        self.number = number


@contextmanager
def interruptible(for_good: bool = False) -> Iterator[list[int]]:
    """Have a signal raise `Stopped` inside, and a second one end the process; `for_good`: it does so ever after.

    Gives the signals that have come: what `Stopped` meets on its way out may have made another error of it.
    """
    heard: list[int] = []
    hook = sys.unraisablehook
    sys.unraisablehook = lambda broken: _lost(broken.exc_value) if heard else hook(broken)

    def stop(number: int, frame: FrameType | None) -> None:
        heard.append(number)
        _stop(number, frame)

    try:
        with _handled(stop):
            yield heard
    finally:
        sys.unraisablehook = hook
        with suppress(ValueError):  # in another thread there was nothing to handle
            signal.setitimer(signal.ITIMER_REAL, 0)
            if for_good:
                _listen(_leave)


def _stop(number: int, _: FrameType | None) -> None:
    """Raise `Stopped`; what is tidied up on its way out has some seconds for it."""
    _listen(_leave)
    signal.signal(signal.SIGALRM, _leave)
    signal.setitimer(signal.ITIMER_REAL, GRACE_SECONDS)
    if number == signal.SIGHUP:
        forget_terminal()
    raise Stopped(number)


def _lost(error: BaseException | None) -> None:
    """End the process where `Stopped` came to a place that lets no error through: it would go on as before."""
    if isinstance(error, Stopped):
        os.write(2, f"regista: {WORDS[error.number]}\n".encode())
        _leave(error.number)


def _leave(number: int = signal.SIGINT, _: FrameType | None = None) -> None:
    """End the process here and now: an exception was lost, or nobody waits any longer."""
    os._exit(128 + (number if number in SIGNALS else signal.SIGINT))


def _listen(handler: Callable[[int, FrameType | None], Any]) -> dict[int, Any]:
    """Handle the signals, but for those that whoever started us wants ignored (nohup); return the handlers before."""
    before: dict[int, Any] = {number: signal.getsignal(number) for number in SIGNALS}
    before = {number: handler for number, handler in before.items() if handler != signal.SIG_IGN}
    for number in before:
        signal.signal(number, handler)
    return before


@contextmanager
def _handled(handler: Callable[[int, FrameType | None], Any]) -> Iterator[None]:
    """Handle the signals while inside; elsewhere than in the main thread that is not possible, nor needed."""
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
    """Let a Ctrl-C wait until this is done; processes that are started meanwhile never hear of one."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def forget_terminal() -> None:
    """Write to nowhere from now on: the terminal, or whoever read what we write, has gone."""
    with suppress(OSError), open(os.devnull, "w") as nowhere:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                os.dup2(nowhere.fileno(), stream.fileno())


def hung_up() -> bool:
    """Say whether we write to a terminal that is no longer there: an I/O error may be a disk's as well."""
    for number in (1, 2):
        try:
            termios.tcgetattr(number)
        except termios.error as error:
            if error.args[0] == errno.EIO:
                return True
    return False


def end_with(parent: int) -> None:
    """Have the kernel send us SIGTERM when the process ends that started us, however it ends. Linux alone can."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGTERM)
        if os.getppid() != parent:  # it has ended in the meantime
            signal.raise_signal(signal.SIGTERM)


class StopRequest:
    """While entered, the first signal only sets `signal`: what is being done ends well. A second Ctrl-C raises."""

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
        """130 after Ctrl-C, 143 after SIGTERM, 129 after the terminal was closed, 0 if nobody asked."""
        return 0 if self.signal is None else 128 + self.signal

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self.signal is not None and number == signal.SIGINT:
            _stop(number, frame)
        if number == signal.SIGHUP:
            forget_terminal()
        self.signal = self.signal or number
