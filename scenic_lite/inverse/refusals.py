"""Why no level is the scene that was asked for, said of one object, property and draw.

Read next: `inverse.levels`, which finds out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.inverse.wishes import Wish
from scenic_lite.scene.naming import title_of
from scenic_lite.values.graph import RandomExpr, columns_of

if TYPE_CHECKING:
    from scenic_lite.inverse.wishes import Subjects
    from scenic_lite.scene.program import Draw, Program

BEYOND = 1e-7  # of θ: farther outside [-1, 1] is no rounding
LISTED = 8  # draws, in one message


class Refusals:
    """Makes the errors for what cannot be met in a program."""

    def __init__(self, program: Program, subjects: Subjects) -> None:
        self.program = program
        self.titles = [instance.title() for instance in subjects.instances]
        self.columns = list(subjects.draws.values())

    def count_of(self, wishes: list[Wish]) -> int:
        """N, the number of scenes that are asked for. Raises ScenicError if the arrays do not agree."""
        counts = {wish.values.shape[0] for wish in wishes if wish.values.ndim and wish.values.shape[0] != 1}
        if len(counts) > 1:
            found = " and ".join(map(str, sorted(counts)))
            raise ScenicError("value", f"the arrays that describe scenes have different lengths: {found}")
        return counts.pop() if counts else 1

    def undetermined(self, columns: list[int]) -> ScenicError:
        """For draws of which what is asked says nothing."""
        draws = [self.program.draws[d] for d in columns]
        names = [f"{draw.name} ({self._line(draw.place)})" for draw in draws[:LISTED]]
        more = [f"{len(draws) - LISTED} more"] if len(draws) > LISTED else []
        message = f"nothing that is asked of the scene decides {', '.join(names + more)}"
        return self.program.error("value", message, draws[0].place, "ask for more, or give default=θ for the rest")

    def unmet(
        self, wishes: list[Wish], missed: np.ndarray, row: int, wanted: np.ndarray, reached: list[Any]
    ) -> ScenicError:
        """For one scene: the first wish that is missed, and what stands against it.

        `missed` [N, W]; `wanted` [D] is θ as it follows from what was asked, perhaps beyond its ends; `reached` [W].
        """
        first = int(np.flatnonzero(missed[row])[0])
        family = [w for w, each in enumerate(wishes) if (each.owner, each.part) == self._key(wishes[first])]
        asked = shown([wishes[w].values[row] for w in family])
        which = f" in scene {row}" if len(missed) > 1 else ""
        message = f"no θ gives {self._subject(wishes[first])} {asked}{which}"
        broken = [w for w in family if missed[row, w]]
        fixed = [w for w in broken if not isinstance(wishes[w].node, RandomExpr)]
        place = wishes[first].place
        if fixed:
            return self.program.error(
                "value", message, place, f"the program fixes it at {shown([reached[w] for w in family])}"
            )
        hint, at = self._reason([wishes[w] for w in broken], wanted)
        if not hint:
            names = ", ".join(draw.name for draw in self._draws([wishes[w] for w in broken])[:LISTED])
            hint = f"as far as the rest allows, {names} can give {shown([reached[w] for w in family])}"
        return self.program.error("value", message, at or place, hint)

    def _reason(self, wishes: list[Wish], wanted: np.ndarray) -> tuple[str, SourceSpan | None]:
        """A draw that would have to lie outside its limits."""
        for draw in self._draws(wishes):
            theta = wanted[self.program.draws.index(draw)]
            if not abs(theta) > 1 + BEYOND:
                continue
            if draw.kind.startswith("point"):
                return f"that is outside the region from which it is drawn on {self._line(draw.place)}", draw.place
            low, high = draw.low, draw.high
            if np.isfinite(low) and np.isfinite(high):
                value = low + (theta + 1) / 2 * (high - low)
                return f"{draw.name} would have to be {value:g}, and lies between {low:g} and {high:g}", draw.place
            return f"{draw.name} would have to lie beyond its limits", draw.place
        points = [draw for draw in self._draws(wishes) if draw.kind.startswith("point")]
        unknown = [draw for draw in points if np.isnan(wanted[self.program.draws.index(draw)])]
        if unknown:
            line = self._line(unknown[0].place)
            return f"that is outside the region from which it is drawn on {line}", unknown[0].place
        return "", None

    def _draws(self, wishes: list[Wish]) -> list[Draw]:
        feeding = {id(column) for wish in wishes for column in columns_of(wish.node)}
        return [draw for draw, column in zip(self.program.draws, self.columns, strict=True) if id(column) in feeding]

    def _key(self, wish: Wish) -> tuple[int | None, str]:
        return wish.owner, wish.part

    def _subject(self, wish: Wish) -> str:
        if wish.owner is None:
            return f"{wish.part} the value"
        return f"{self.titles[wish.owner]} the {wish.part}"

    def _line(self, place: SourceSpan) -> str:
        return f"line {place.line}" if place.file == self.program.file else f"{place.file}, line {place.line}"


def shown(values: list[Any]) -> str:
    """A value, or the coordinates of a vector."""
    parts = [f"{value:g}" if isinstance(value, int | float | np.number) else title_of(value) for value in values]
    return parts[0] if len(parts) == 1 else f"({' @ '.join(parts)})"
