"""Settings of worker processes. Read next: `adapters.gym`, whose environments may run in separate processes."""

from __future__ import annotations

import ctypes
import sys
from contextlib import suppress

PR_SET_PDEATHSIG = 1  # of prctl(2)

# How environment processes start. Python 3.14 does not fork on Linux by default: it pickles the functions that make
# environments, and imports torch in every process.
START_METHOD = "fork" if sys.platform == "linux" else None  # None: Python's default


def end_with_parent(number: int) -> None:
    """Make the kernel send this process a signal when its parent ends for any reason. Only Linux supports this."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, number)
