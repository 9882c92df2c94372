"""The two ways in which a command can fail that are the user's business: one sentence each, no traceback.

Read next: `__main__`, which prints them.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class CommandError(Exception):
    """Something went wrong that the user can act on. The message is one sentence; the exit code is 1."""

    exit_code = 1


class UsageError(CommandError):
    """The command line itself is wrong. The exit code is 2, as every Unix tool has it."""

    exit_code = 2


def nearest(word: str, words: Iterable[str]) -> str:
    """Give ` (did you mean 'x'?)` for the word that `word` is probably meant to be, or nothing."""
    known = {candidate.lower(): candidate for candidate in words}
    close = get_close_matches(word.lower(), known, n=1, cutoff=0.6)
    return f" (did you mean '{known[close[0]]}'?)" if close else ""
