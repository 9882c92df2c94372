"""What a field of a record may hold: in a table of fields this stands in place of a bare type.

Light: programs are read without Numba. Read next: `state`, the tables; `limits`, which checks records by them.
"""

from __future__ import annotations

from typing import NamedTuple

LARGEST = 1e9  # magnitude of a real number in a record: far beyond any pitch, and yet a fine integer


class Whole(NamedTuple):
    """A whole number from `low` to `high`; below the number of things that `high` names, where it is a name.

    `given`: a match has what the line-up of its program gives it, and nothing else.
    """

    low: int
    high: int | str
    given: bool = False

    def __str__(self) -> str:
        return f"a whole number from {self.low:,} to {self.high:,}"


class Real(NamedTuple):
    """A number of this magnitude at most: NaN never is."""

    largest: float = LARGEST

    def __str__(self) -> str:
        return f"a number from {-self.largest:g} to {self.largest:g}"


class Place(NamedTuple):
    """A number that the machine takes for a place among so many, whole or not: not negative, and less than that."""

    places: int

    def __str__(self) -> str:
        return f"a number from 0 to {self.places - 1:,}"


Kind = Whole | Real | Place | str  # or what NumPy calls it: "?" for truth values, "u8" where any 64 bits will do
Table = tuple[tuple[str, Kind, tuple[int, ...], str, str], ...]  # name, kind, shape, unit, meaning


def stored(kind: Kind) -> str:
    """Return how NumPy stores such a field."""
    return kind if isinstance(kind, str) else "i8" if isinstance(kind, Whole) else "f8"
