"""Random numbers from the stream in a record's field `random`, identical for any number of threads.

The generator is Marsaglia's xorshift64 (Journal of Statistical Software 8(14), 2003). It uses shifts and exclusive ors
only, so uncompiled code raises no overflow warnings. Streams start from SplitMix64 hashes of the seeds (Steele, Lea
and Flood, OOPSLA 2014). Football matches and the virtual machine of behaviors (`dynamics.machine.vm`) use it.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from regista.kernels.jit import kernel

_A, _B, _C = np.uint64(13), np.uint64(7), np.uint64(17)
_FIRST, _BITS = 0x9E3779B97F4A7C15, 2**64 - 1
_STEP, _FACTORS = np.uint64(_FIRST), (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))
_30, _27, _31 = np.uint64(30), np.uint64(27), np.uint64(31)
_TO_53_BITS = np.uint64(11)
_UNIT = 2.0**-53
_TWO_PI = 2.0 * math.pi


def streams(seeds: npt.ArrayLike) -> np.ndarray:
    """Hash seeds [N] into nonzero starting states [N] uint64 (0 is forbidden)."""
    return np.array([stream(seed) for seed in np.atleast_1d(np.asarray(seeds)).astype(np.uint64).tolist()], np.uint64)


def stream(seed: int) -> int:
    """Hash a seed of 64 bits into a nonzero starting state (0 is forbidden)."""
    state = seed + _FIRST & _BITS
    state = (state ^ state >> 30) * 0xBF58476D1CE4E5B9 & _BITS
    state = (state ^ state >> 27) * 0x94D049BB133111EB & _BITS
    return state ^ state >> 31 or _FIRST


@kernel
def start_of(seed):
    """Return `stream(seed)` for a uint64 seed, inside kernels."""
    state = seed + _STEP
    state = (state ^ (state >> _30)) * _FACTORS[0]
    state = (state ^ (state >> _27)) * _FACTORS[1]
    state = state ^ (state >> _31)
    return state if state != np.uint64(0) else _STEP


@kernel
def uniform(rng):
    """Draw from [0, 1) and advance the stream of `rng`, a record, by one."""
    state = rng.random
    state ^= state << _A
    state ^= state >> _B
    state ^= state << _C
    rng.random = state
    return float(state >> _TO_53_BITS) * _UNIT


@kernel
def normal(rng):
    """Draw from the standard normal distribution by the Box-Muller method: two uniform draws."""
    radius = math.sqrt(-2.0 * math.log(1.0 - uniform(rng)))
    return radius * math.cos(_TWO_PI * uniform(rng))
