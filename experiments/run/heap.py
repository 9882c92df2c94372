"""Settings of the C library for freed memory. Read next: `run.build`, which applies them to every training run."""

from __future__ import annotations

import ctypes

# Parameters of `mallopt` (malloc.h) and their values in bytes.
KEEP = {
    -3: 32 * 2**20,  # M_MMAP_THRESHOLD: blocks of at least this size get their own pages; the maximum value
    -1: 2_000_000_000,  # M_TRIM_THRESHOLD: maximum free bytes at the end of the heap; more are returned to the system
    -2: 64 * 2**20,  # M_TOP_PAD: bytes by which the heap grows beyond a request; unused ones take no memory
}


def keep_freed_memory() -> bool:
    """Make the C library keep freed memory for the next request; return whether it supports this (glibc on Linux).

    By default glibc returns large blocks to the system as soon as they are free. Each torch operation on a minibatch
    allocates such blocks for its result and frees its inputs. So the system repeatedly allocates and clears the same
    pages: a PPO update on 8,192 steps causes 1,000 to 2,500 page faults. The cost of this setting is that the process
    keeps its peak memory, at most 2 GB of it, until it ends.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):  # another C library; on Windows, CDLL(None) fails
        return False
    return 0 not in {mallopt(parameter, value) for parameter, value in KEEP.items()}
