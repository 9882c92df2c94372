"""Random numbers while an episode runs, from the match's own stream.

The generator is the one of compiled programs, `stream`, on Python's integers, so that a program draws the same numbers
both ways: xorshift64, started from a SplitMix64 hash of the seed. Read next: `dynamics.reference.episode`.
"""

from __future__ import annotations

MASK = 2**64 - 1
GOLDEN = 0x9E3779B97F4A7C15


def first_state(seed: int) -> int:
    """The state that a stream starts from: a hash of the seed, never 0."""
    state = (seed + GOLDEN) & MASK
    state = (state ^ (state >> 30)) * 0xBF58476D1CE4E5B9 & MASK
    state = (state ^ (state >> 27)) * 0x94D049BB133111EB & MASK
    state ^= state >> 31
    return state or GOLDEN


class Draws:
    """A stream of uniform numbers."""

    def __init__(self, seed: int) -> None:
        self.state = first_state(seed)

    def uniform(self) -> float:
        """The next number in [0, 1)."""
        state = self.state
        state ^= state << 13 & MASK
        state ^= state >> 7
        state ^= state << 17 & MASK
        self.state = state
        return (state >> 11) * 2.0**-53
