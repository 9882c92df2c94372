"""Rejects tampered checkpoints: every field of an external record is checked against its limits.

Kernels check no bounds: an index out of range writes into the next match. So all code that loads an external state
first checks each of its 64-bit words against the tables of `state`. This holds for `set_state`, and through it for
checkpoints and records of matches. Read next: `field_kinds`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np

from regista.envs.football.field_kinds import Kind, Place, Real, Table, Whole, stored
from regista.kernels.jit import kernel

MAGNITUDE = np.int64(2**63 - 1)  # masks the sign of a double; the remaining bits order like the magnitudes
WORD = 8  # bytes


class StateError(ValueError):
    """A state that does not fit these matches; the message gives the field, its value and the valid values."""


def bits(number: float) -> int:
    """Return the 64 bits of a double as an integer."""
    return int(np.float64(number).view(np.int64))


class Limits:
    """The limits of every 64-bit word of a row: the least and greatest value of a word's masked bits, as integers.

    Args:
        fields: the name of each field, its first byte, and its kind.
        counts: the numbers of players and agents.
        given: one valid row, as words; fields of kind `given` must have the values of this row.
        random: names of fields exempt from `given`, since the program draws them.

    Attributes:
        masks, lows, highs: int64 `[W]`.
        used: int64 `[W]`, the bits of a word that belong to a field.
        fields: the name of each of these fields, its first byte, and its kind.
    """

    def __init__(
        self,
        fields: list[tuple[str, int, Kind]],
        counts: Mapping[str, int],
        given: np.ndarray | None = None,
        random: Collection[str] = (),
    ) -> None:
        size = 1 + max((at for _, at, _ in fields), default=-WORD) // WORD
        self.masks, self.lows, self.highs, self.used = (np.zeros(size, np.int64) for _ in range(4))
        self.fields = [(name, at, self._numbered(kind, counts)) for name, at, kind in fields]
        masks, used = self.masks.view(np.uint8), self.used.view(np.uint8)
        for name, at, kind in self.fields:
            word = at // WORD
            used[at : at + (1 if kind == "?" else WORD)] = 0xFF
            if kind == "?":
                masks[at] = 0xFE  # the byte is 0 or 1
            elif isinstance(kind, Real):
                self.masks[word], self.highs[word] = MAGNITUDE, bits(kind.largest)
            elif isinstance(kind, Place):
                self.masks[word], self.highs[word] = -1, bits(kind.places - 1)
            elif isinstance(kind, Whole):
                self.masks[word] = -1
                self.lows[word], self.highs[word] = kind[:2]
                if kind.given and given is not None and name not in random:
                    self.lows[word] = self.highs[word] = given[word]

    @classmethod
    def of_array(cls, size: int, kinds: Mapping[int, Kind], counts: Mapping[str, int] | None = None) -> Limits:
        """Return the limits of rows of `size` 64-bit numbers, of which `kinds` gives the kind of some."""
        return cls([(f"[{i}]", WORD * i, kinds.get(i, "f8")) for i in range(size)], counts or {})

    @staticmethod
    def _numbered(kind: Kind, counts: Mapping[str, int]) -> Kind:
        if isinstance(kind, Whole) and isinstance(kind.high, str):
            return kind._replace(high=counts[kind.high] - 1)
        return kind

    def check(self, rows: np.ndarray, where: str) -> None:
        """Raise `StateError` unless every field of rows `[N, ...]` is within its limits."""
        words = words_of(rows)
        wrong = first_outside(words, self.used, self.masks, self.lows, self.highs)
        if wrong >= 0:
            row, word = divmod(wrong, len(self.masks))
            raise StateError(f"{where}[{row}]{self._explained(words[row], word)}")

    def _explained(self, words: np.ndarray, word: int) -> str:
        """Return the message for one invalid word of a row `[W]`."""
        low, high, content = self.lows[word], self.highs[word], words.view(np.uint8)
        for name, at, kind in self.fields:
            if kind == "?" and at // WORD == word and content[at] > 1:
                return f"{name} is the byte {content[at]}; it must be 0 or 1"
            if kind != "?" and at // WORD == word:
                value = words[word : word + 1].view(stored(kind))[0]
                limits = f"{low}, as in the program" if low == high and isinstance(kind, Whole) else kind
                return f"{name} is {value:g}; it must be {limits}"
        raise AssertionError(f"no field has word {word}")


def words_of(rows: np.ndarray) -> np.ndarray:
    """Return rows `[N, ...]` as words of 64 bits `[N, W]`: a view if they are contiguous."""
    rows = np.ascontiguousarray(rows)
    return rows.reshape(-1).view(np.int64).reshape(len(rows), rows.nbytes // WORD // max(len(rows), 1))


def fields_of(dtype: np.dtype, tables: Mapping[np.dtype, Table], path: str = "", at: int = 0) -> Iterator[Any]:
    """Yield name, first byte and kind of every number in a record, given the tables of its parts."""
    kinds = {name: kind for name, kind, *_ in tables[dtype]}
    for name, (part, offset, *_) in (dtype.fields or {}).items():
        base, shape = part.subdtype or (part, ())
        for place, index in enumerate(np.ndindex(*shape)):
            inside = f"{path}.{name}" + "".join(f"[{number}]" for number in index)
            begin = at + offset + place * base.itemsize
            if base.fields:
                yield from fields_of(base, tables, inside, begin)
            else:
                yield inside, begin, kinds[name]


@kernel
def first_outside(words, used, masks, lows, highs):
    """Return the index of the first of the words [N, W] outside its limits [W], or -1.

    A row of zeros is valid: it is a match that has not begun.
    """
    for row in range(words.shape[0]):
        wrong, begun = False, False
        for word in range(words.shape[1]):
            value = words[row, word] & masks[word]
            wrong |= (value < lows[word]) | (value > highs[word])
        for word in range(words.shape[1]):
            begun |= wrong and words[row, word] & used[word] != 0
        if begun:
            for word in range(words.shape[1]):
                value = words[row, word] & masks[word]
                if value < lows[word] or value > highs[word]:
                    return row * words.shape[1] + word
    return -1
