"""The two ways in which a command can fail that are the user's business: one sentence each, no traceback.

Read next: `__main__`, the commands.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from difflib import get_close_matches


class CommandError(Exception):
    """Something went wrong that the user can act on. The message is one sentence; the exit code is 1."""

    exit_code = 1


class UsageError(CommandError):
    """The command line itself is wrong. The exit code is 2, as every Unix tool has it."""

    exit_code = 2


def nearest(word: str, words: Iterable[str], most: int = 1) -> str:
    """Return ` (did you mean 'x'?)` for the words that `word` is probably meant to be, or nothing.

    Of several, those that contain it come first.
    """
    known = {candidate.lower(): candidate for candidate in words}
    inside = [name for name in known if word.lower() in name] if most > 1 else []
    close = [*dict.fromkeys(inside + get_close_matches(word.lower(), known, n=most, cutoff=0.6))][:most]
    shown = " or ".join(f"'{known[name]}'" for name in close)
    return f" (did you mean {shown}?)" if close else ""


def run_command(command: Callable[[list[str]], int], argv: Sequence[str]) -> int:
    """Return the exit code of `command(argv)`; an error that is the user's business is one sentence."""
    words = list(argv)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    try:
        return command(words)
    except BrokenPipeError:  # `regista inspect ... | head`
        sys.stderr.close()
        return 1
    except Exception as error:
        code = _exit_code(error)
        if debug or code is None:
            raise
        # An error in a program begins with its place, file:line:column, where editors look for it.
        print(error if getattr(error, "place", None) else f"regista: {error}", file=sys.stderr)
        return code


def _exit_code(error: Exception) -> int | None:
    """Return the exit code of an error that is the user's business, None for one that is ours."""
    if isinstance(error, CommandError):
        return error.exit_code
    if isinstance(error, OSError) and error.filename is not None:
        return 1
    # Named, not imported: neither the language nor the learning core is loaded for the sake of an error.
    ours = {"ScenicError", "NotAMatchError", "ThetaError", "LevelError", "CheckpointError", "FloatingPointError"}
    ours |= {"GrfError"}
    return 1 if ours & {kind.__name__ for kind in type(error).__mro__} else None
