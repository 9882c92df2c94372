"""How the C library keeps memory that was freed. Read next: `run.build`, which calls it for every training run."""

from __future__ import annotations

import ctypes

# Parameters of `mallopt` (malloc.h) and their values in bytes.
KEEP = {
    -3: 32 * 2**20,  # M_MMAP_THRESHOLD, from which on a block has pages of its own: the largest value allowed
    -1: 2_000_000_000,  # M_TRIM_THRESHOLD: free bytes at the end of the heap above which they go back to the system
    -2: 64 * 2**20,  # M_TOP_PAD: bytes by which the heap grows beyond what is requested; untouched ones take no memory
}


def keep_freed_memory() -> bool:
    """Let the C library keep freed memory for the next request; return whether it can (glibc on Linux can).

    By default glibc returns large blocks to the system as soon as they are free. Each operation of torch on a minibatch
    allocates such blocks for its result and frees its inputs, so the system hands out, and clears, the same pages
    again and again: 1,000 to 2,500 page faults in an update of PPO on 8,192 steps. In exchange, the process keeps the
    memory that it had at its peak, at most 2 GB of it, until it ends.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):  # another C library; Windows has no library of this process
        return False
    return 0 not in {mallopt(parameter, value) for parameter, value in KEEP.items()}
