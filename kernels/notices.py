"""Progress messages on stderr while this or another process compiles kernels: name, progress and elapsed time.

On a terminal a thread redraws one line and removes it at the end; elsewhere each kind of message is printed once. Work
shorter than a second prints nothing, so loading from the cache is silent. Read next: `kernels.numba_linking`, which
reports its work to this module.
"""

from __future__ import annotations

import os
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from types import CodeType
from typing import Any

PATIENCE = 1.0  # seconds before the first message
REDRAW_SECONDS = 0.2
COMPILING = "compiling kernels"
WAITING = "another process is compiling the kernels; waiting"
_said: set[str] = set()


def say_once(text: str) -> None:
    """Print a line on stderr unless this process has printed it; ignore errors."""
    if text not in _said:
        _said.add(text)
        _write(f"{text}\n")


def _write(text: str) -> None:
    with suppress(OSError, ValueError, AttributeError):  # stderr is closed or missing
        sys.stderr.write(text)
        sys.stderr.flush()


class _Work:
    """The compiler's current work; if work is nested, only the outermost is shown.

    `entries`: names of the programs to compile, if known. `usual`: their usual compilation time in seconds, or 0.
    """

    def __init__(self, entries: Sequence[str], usual: int) -> None:
        self.entries, self.usual = tuple(entries), usual
        self.began = time.monotonic()
        self.entry = ""  # the program being compiled
        self.reached: set[Callable] = set()  # its functions
        self.waiting: float | None = None  # start time of waiting for another process that compiles
        self.generating = False  # all functions have been read, and machine code is generated

    def line(self) -> str:
        """Return the line for a terminal; it is empty while nothing is compiled."""
        now = time.monotonic()
        if self.waiting is not None:
            return f"{WAITING}, {now - self.began:.0f} s"
        if not self.entry:
            return ""
        words = [f"{COMPILING} (once): {self.entry}"]
        if self.entry in self.entries:
            words[0] += f" ({self.entries.index(self.entry) + 1} of {len(self.entries)})"
        done = len(self.reached & _compiled)
        words.append("machine code" if self.generating else f"{done} of {len(self.reached)} functions")
        return ", ".join([*words, f"{now - self.began:.0f} s"])

    def plain(self) -> str:
        """Return the line for outputs other than a terminal; it is empty if there is nothing to report."""
        if self.waiting is not None:
            return WAITING if time.monotonic() - self.waiting >= PATIENCE else ""
        about = f", about {self.usual} s" if self.usual else ""
        return f"{COMPILING} (once on this machine{about})" if self.entry else ""


_compiled: set[Callable] = set()  # functions that this process has compiled, as parts of programs
_work: _Work | None = None  # the work that is shown


@contextmanager
def at_work(entries: Sequence[str] = (), usual: int = 0) -> Iterator[_Work]:
    """Show the compiler's work inside the context; nested contexts report to the outermost one."""
    global _work
    if _work is not None:
        yield _work
        return
    _work = _Work(entries, usual)
    ended = threading.Event()
    showing = threading.Thread(target=_show, args=(_work, ended), daemon=True)
    showing.start()
    try:
        yield _work
    finally:
        _work = None
        ended.set()
        showing.join()


def _show(work: _Work, ended: threading.Event) -> None:
    """Draw the line until the work has ended; then remove it."""
    terminal, drawn = sys.stderr is not None and sys.stderr.isatty(), False
    if ended.wait(PATIENCE):
        return
    while not ended.wait(REDRAW_SECONDS):
        if terminal and (line := work.line()):
            _write(f"\r\x1b[K{line[: shutil.get_terminal_size().columns - 1]}")
            drawn = True
        elif not terminal and (line := work.plain()):
            say_once(line)
    if drawn:
        _write("\r\x1b[K")


def _forget() -> None:
    """Show nothing in a forked process, whose copy of the work has no thread."""
    global _work
    _work = None


os.register_at_fork(after_in_child=_forget)


@contextmanager
def compiling(function: Callable) -> Iterator[None]:
    """Show that the program with this entry function is compiled."""
    with at_work() as work:
        work.entry, work.reached, work.generating = function.__name__, reached(function), False
        try:
            yield
        finally:
            work.entry = ""
            _compiled.add(function)


@contextmanager
def waiting() -> Iterator[None]:
    """Show that this process waits for another process that compiles the kernels."""
    with at_work() as work:
        work.waiting = time.monotonic()
        try:
            yield
        finally:
            work.waiting = None


def compiled_part(function: Callable) -> None:
    """Count a function of the program as compiled."""
    _compiled.add(function)


def generating() -> None:
    """Show that all functions of the program have been read, and machine code is generated."""
    if _work is not None:
        _work.generating = True


def reached(function: Callable) -> set[Callable]:
    """Return a function and all kernels that it may call, directly or indirectly, as Python functions."""
    seen: set[Callable] = set()
    pending: list[Any] = [function]
    while pending:
        one = pending.pop()
        if one not in seen:
            seen.add(one)
            known = [one.__globals__.get(name) for name in names_in(one.__code__)]
            pending += [kernel.py_func for kernel in known if hasattr(kernel, "py_func")]
    return seen


def names_in(code: CodeType) -> set[str]:
    """Return all names that the code, including nested code, reads."""
    inside = [part for part in code.co_consts if isinstance(part, CodeType)]
    return {*code.co_names}.union(*map(names_in, inside))
