"""A level family with a known answer: words of four letters, whose score is the number of letters "a"."""

import numpy as np

from ued.core.cells import bin_center, index_in
from ued.core.parameters import Choice

LETTERS, LENGTH = "abcd", 4


class Words:
    """Neither columns nor steps: a family that no adversary can choose."""

    size = LENGTH

    def sample(self, rng):
        return "".join(rng.choice(list(LETTERS), LENGTH))

    def mutate(self, level, rng):
        at, letter = rng.integers(LENGTH), rng.choice(list(LETTERS))
        return level[:at] + letter + level[at + 1 :]

    def encode(self, level):
        return bin_center(np.array([LETTERS.index(letter) for letter in level]), len(LETTERS))

    def decode(self, code):
        return "".join(LETTERS[index] for index in index_in(code, len(LETTERS)))


class DeclaredWords(Words):
    """Words as four columns; random words prefer "d"."""

    parameters = {f"letter {k}": Choice(*LETTERS, weights=(1, 1, 1, 5)) for k in range(LENGTH)}  # noqa: RUF012


class Typist:
    """Types one letter per step. Luck is a last letter that replaces the typed one in words of odd luck."""

    steps, actions = LENGTH, len(LETTERS)

    def begin(self, luck):
        return luck, np.zeros((len(luck), 0), np.int64)

    def apply(self, levels, actions):
        luck, typed = levels
        assert actions.dtype == np.int64
        return luck, np.column_stack([typed, actions])

    def observe(self, levels):
        luck, typed = levels
        seen = np.zeros((len(luck), LENGTH))
        seen[:, : typed.shape[1]] = bin_center(typed, len(LETTERS))
        return seen

    def codes(self, levels):
        luck, typed = levels
        typed = typed.copy()
        typed[luck % 2 == 1, -1] = len(LETTERS) - 1
        return bin_center(typed, len(LETTERS))


class TypedWords(Words):
    """Words that are typed letter by letter."""

    builder = Typist()


class BothWords(DeclaredWords, TypedWords):
    """Words that can be chosen at once, or typed."""


def letters_a(theta):
    """Return the number of letters "a" in the words of codes `[n, LENGTH]`."""
    return (index_in(theta, len(LETTERS)) == 0).sum(1).astype(float)
