"""What a process asks of the system. Read next: `adapters.gym`, whose environments may have processes of their own."""

from __future__ import annotations

import ctypes
import sys
from contextlib import suppress

PR_SET_PDEATHSIG = 1  # of prctl(2)

# How processes of environments start. Python 3.14 no longer forks on Linux by default: it would pickle the functions
# that make environments, and import torch in every process.
START_METHOD = "fork" if sys.platform == "linux" else None  # None: Python's own choice


def end_with_parent(number: int) -> None:
    """Have the kernel send us this signal when the process that started us ends, however it ends. Linux alone can."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, number)
