"""What ends a command from outside: Ctrl-C, SIGTERM, a closed terminal, a reader that has gone, a parent that died.

A command that does not say otherwise ends where it is (`interruptible`); one that has something to save takes the
signal as a request (`StopRequest`). Either way it is one line and 128 + the signal's number, and nobody is left behind.
Whatever the main thread does meanwhile, `Watchdog` ends the process some seconds after the signal: files are replaced
in one step, so what was finished is whole, and a resumed run goes on from its last checkpoint.
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
# After a signal, what is being done may end well; then the process ends anyway. A run that somebody else started, who
# was sent the signal and passed it on, ends before that one does.
GRACE_SECONDS, CHILD_GRACE_SECONDS = 8.0, 6.0
PARENT = "REGISTA_PARENT"  # in the environment of a run: the process with which it is to end


_is_child = False  # of another command of ours


class Stopped(KeyboardInterrupt):
    """Somebody wants the command to end: `number` is the signal."""

    def __init__(self, number: int) -> None:
        super().__init__(WORDS[number])
        self.number = number


class Watchdog:
    """While entered, a signal ends the process after a grace period, unless we are left before.

    A handler of Python's waits until the main thread is out of whatever call it is in. So the number is also written
    into a pipe, by the handler that the system calls, and read by a thread.
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
        except ValueError:  # not in the main thread, which alone hears signals
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
        asked = None
        while asked is None:
            said = os.read(reading, 1)
            if not said:
                return
            asked = said[0] if said[0] in SIGNALS else None
        until = time.monotonic() + self.seconds
        while (left := until - time.monotonic()) > 0:
            if select.select([reading], [], [], left)[0] and not os.read(reading, 1):
                return
        _say(WORDS[asked])
        _leave(asked)


_fork = threading.local()  # the signals that the forking thread had blocked


def _hold_signals() -> None:
    """Let no signal come between a fork and `_forget_pipe`: it would be written into the pipe of the other process."""
    _fork.blocked = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)


def _release_signals() -> None:
    signal.pthread_sigmask(signal.SIG_SETMASK, _fork.blocked)


def _forget_pipe() -> None:
    """Let a forked process write its signals to nobody: they are not ours."""
    with suppress(ValueError):
        signal.set_wakeup_fd(-1)
    _release_signals()


os.register_at_fork(before=_hold_signals, after_in_parent=_release_signals, after_in_child=_forget_pipe)


def _say(word: str) -> None:
    """Write a last line, unless whoever reads it is in the way."""
    with suppress(OSError):
        if select.select([], [2], [], 0)[1]:
            os.write(2, f"regista: {word}\n".encode())


def watchdog() -> Watchdog:
    """Return the watchdog of a command: it has less time where another command has started it."""
    return Watchdog(CHILD_GRACE_SECONDS if _is_child else GRACE_SECONDS)


@contextmanager
def interruptible(for_good: bool = False) -> Iterator[list[int]]:
    """Have a signal raise `Stopped` inside, and a second one end the process; `for_good`: it does so ever after.

    Gives the signals that have come: what `Stopped` meets on its way out may have made another error of it.
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
        sys.unraisablehook = hook
        if for_good:  # whatever is tidied up at the end of the process is watched, too
            with suppress(ValueError):  # in another thread there was nothing to handle
                _listen(_leave)
        else:
            watching.__exit__()


def _stop(number: int, _: FrameType | None) -> None:
    """Raise `Stopped`; what is tidied up on its way out has some seconds for it, see `Watchdog`."""
    _listen(_leave)
    if number == signal.SIGHUP:
        forget_terminal()
    raise Stopped(number)


def _lost(error: BaseException | None) -> None:
    """End the process where `Stopped` came to a place that lets no error through: it would go on as before."""
    if isinstance(error, Stopped):
        _say(WORDS[error.number])
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
    global _is_child
    _is_child = True
    end_with_parent(signal.SIGTERM)
    if sys.platform == "linux" and os.getppid() != parent:  # it has ended in the meantime
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
