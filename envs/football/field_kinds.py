"""The kinds of a record's fields: types with limits, with which `limits` rejects tampered checkpoints.

Importing it does not load Numba. Read next: `state`, the tables; `limits`, which checks records by them.
"""

from __future__ import annotations

from typing import NamedTuple

LARGEST = 1e9  # maximum magnitude of a real number in a record: far beyond any pitch, and safe to convert to an integer


class Whole(NamedTuple):
    """A whole number from `low` to `high`; if `high` is the name of a count, from `low` to below that count.

    `given`: the value must equal the one from the program's line-up.
    """

    low: int
    high: int | str
    given: bool = False

    def __str__(self) -> str:
        return f"a whole number from {self.low:,} to {self.high:,}"


class Real(NamedTuple):
    """A real number of at most this magnitude, and not NaN."""

    largest: float = LARGEST

    def __str__(self) -> str:
        return f"a number from {-self.largest:g} to {self.largest:g}"


class Place(NamedTuple):
    """A number, whole or not, that the virtual machine uses as an index into `places` entries: 0 to below `places`."""

    places: int

    def __str__(self) -> str:
        return f"a number from 0 to {self.places - 1:,}"


Kind = Whole | Real | Place | str  # or NumPy's name: "?" for booleans, "u8" for any 64 bits
Table = tuple[tuple[str, Kind, tuple[int, ...], str, str], ...]  # name, kind, shape, unit, meaning


def stored(kind: Kind) -> str:
    """Return NumPy's type of a field of this kind."""
    return kind if isinstance(kind, str) else "i8" if isinstance(kind, Whole) else "f8"
