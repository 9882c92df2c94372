"""Errors that the user can act on: each prints one sentence without a traceback.

Read next: `__main__`, the commands.
"""

from __future__ import annotations

import errno
import re
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches

from regista.experiments.run.launch.signals import WORDS, forget_terminal, hung_up, interruptible

OUT_OF_MEMORY = "there is not enough memory"
USERS = {
    *("ScenicError", "ThetaError", "LevelError", "NotAMatchError", "StateError", "RecordError", "CheckpointError"),
    *("FloatingPointError", "GrfError", "OwnCodeError"),
}


class CommandError(Exception):
    """An error that the user can act on. The message is one sentence; the exit code is 1."""

    exit_code = 1


# Errors that invalid values in a damaged file can cause in the code that reads them.
DAMAGE = (ValueError, KeyError, TypeError, IndexError, AttributeError, RuntimeError, OverflowError, AssertionError)


class UsageError(CommandError):
    """Invalid command line. The exit code is 2, as usual on Unix."""

    exit_code = 2


class TaskError(CommandError):
    """The code of a task in Python failed, or returned an object of the wrong type."""


# Optional packages, and the extra that installs each
EXTRAS = {
    "matplotlib": "all",
    "PIL": "all",
    "pyarrow": "all",
    "rerun": "all",
    "numba": "all",
    "shapely": "all",
    "minari": "demonstrations",
    "pandas": "data",
    "ray": "ray",
}


def refused(error: Exception) -> str:
    """Return the message of an error as part of a sentence; a KeyError becomes "... is missing"."""
    if isinstance(error, KeyError):
        return f"{error} is missing"
    first, _, rest = str(error).partition("\n")
    rest = rest.strip().partition("\n")[0]
    network = re.fullmatch(r"Error\(s\) in loading state_dict for (\w+):", first)  # torch's message lists every weight
    return f"its {network[1]} has other weights: {rest.rstrip('. ')}" if network else first


@contextmanager
def read_from(what: str) -> Iterator[None]:
    """Convert errors from reading damaged files into a `CommandError`; `what` is the start of its message."""
    try:
        yield
    except DAMAGE as error:
        raise CommandError(f"{what} damaged: {refused(error)}") from error


def nearest(word: str, words: Iterable[str], most: int = 1) -> str:
    """Return ` (did you mean 'x'?)` with the known words closest to `word`, or an empty string.

    Known words that contain `word` come first.
    """
    known = {candidate.lower(): candidate for candidate in words}
    inside = [name for name in known if word.lower() in name] if most > 1 else []
    close = [*dict.fromkeys(inside + get_close_matches(word.lower(), known, n=most, cutoff=0.6))][:most]
    shown = " or ".join(f"'{known[name]}'" for name in close)
    return f" (did you mean {shown}?)" if close else ""


def run_command(command: Callable[[list[str]], int], argv: Sequence[str], for_good: bool = False) -> int:
    """Run `command(argv)` and return its exit code; print one sentence for errors that the user can act on.

    A signal gives 128 + its number. With `for_good`, signals after the command still end the process.
    """
    words = list(argv)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    heard: list[int] = []
    try:
        with interruptible(for_good) as heard:
            try:
                code = command(words)
            finally:  # flush also after --help, which raises SystemExit, to detect a closed pipe
                sys.stdout.flush()
    except (Exception, KeyboardInterrupt) as error:
        if isinstance(error, KeyboardInterrupt) and not heard:
            heard.append(signal.SIGINT)
        code = 0 if heard else _failed(error, debug)
    if heard:
        print(f"regista: {WORDS[heard[0]]}", file=sys.stderr, flush=True)
        return 128 + heard[0]
    return code


def _failed(error: BaseException, debug: bool) -> int:
    """Print the error and return the exit code; re-raise internal errors."""
    gone = isinstance(error, OSError) and (error.errno == errno.EPIPE or (error.errno == errno.EIO and hung_up()))
    if gone and error.filename is None:  # type: ignore[attr-defined]
        forget_terminal()  # `regista inspect ... | head`
        return 128 + signal.SIGPIPE
    if isinstance(error, ModuleNotFoundError) and error.name in EXTRAS and not debug:
        print(f"regista: this command needs {error.name}: pip install 'regista[{EXTRAS[error.name]}]'", file=sys.stderr)
        return 1
    code = exit_code(error)
    if debug or not code:
        raise error
    # An error in a program starts with its location, file:line:column, which editors recognize.
    print(error if getattr(error, "place", None) else f"regista: {str(error) or OUT_OF_MEMORY}", file=sys.stderr)
    return code


def exit_code(error: BaseException) -> int:
    """Return the exit code of an error that the user can act on, 0 for an internal error."""
    if isinstance(error, CommandError):
        return error.exit_code
    if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno is not None):
        return 1
    # Compared by name, so that an error does not import the language or the learning core.
    return int(bool(USERS & {kind.__name__ for kind in type(error).__mro__}))
