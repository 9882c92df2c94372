"""From a scene back to θ: what is asked is compared with what the tape gives, and θ is moved until the two agree.

Placements are affine in θ nearly everywhere, so that one step of least squares on a numerical Jacobian mostly does;
a coarse scan of θ gives further starts, for choices and curved regions. Every answer is verified; what is not met, or
not decided by what is asked, is refused. Read next: `values.graph`, the tape.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.state import LoadState
from scenic_lite.core.types import Instance, near
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene.naming import ThetaLayout
from scenic_lite.values.formulas import TURN
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, columns_of, kind_of

CLOSE = 1e-6  # relative, from 1 on: two numbers that agree so far are the same
SCAN = 4096  # θ at which everything is computed once
STARTS = 8  # of these, the nearest to a scene, from which steps lead on
ROUNDS = 60  # steps from one start
NUDGE = 1e-7  # of [0, 1], for derivatives


class Target(NamedTuple):
    """A number or text of the scenes and what it shall be, an array [N] or [1]; `what`: "ego the position"."""

    what: str
    value: Value
    asked: np.ndarray
    place: SourceSpan


class Inverse:
    """The way back from the scenes of one program: what can be asked of them, and the θ that gives it."""

    def __init__(self, state: LoadState, objects: Sequence[Instance], layout: ThetaLayout) -> None:
        self.layout = layout
        drawn = zip(layout.draws, layout.columns, strict=True)
        self.known: dict[Any, tuple[Value, SourceSpan]] = {d.name: (column.shown, d.place) for d, column in drawn}
        self.known |= {name: (value, state.param_places[name]) for name, value in state.params.items()}
        for key, instance in [*enumerate(objects), *((each.title(), each) for each in objects)]:
            self.known[key] = instance, instance.place

    def theta(self, description: Mapping[Any, Any], default: np.ndarray | None) -> np.ndarray:
        """Find theta [N, D] of some scenes; `default` [1, D] or [N, D] decides the draws of which nothing is asked.

        Raises ScenicError naming the draws that nothing decides, or the value that is not met.
        """
        targets = [target for key, asked in description.items() for target in self._targets(key, asked)]
        lengths = sorted({len(target.asked) for target in targets} - {1})
        if len(lengths) > 1:
            message = f"the arrays that describe scenes have different lengths: {' and '.join(map(str, lengths))}"
            raise ScenicError("value", message)
        count = lengths[0] if lengths else 1
        if default is not None and len(default) not in (1, count):
            raise ValueError(f"default must be one row of theta or {count} of them, not {len(default)}")
        groups = groups_of(targets, self.layout.columns)
        if default is None:
            self._refuse_undecided({d for _, columns in groups for d in columns})
        unit = np.full((count, len(self.layout.columns)), 0.5)  # [N, D], in [0, 1]
        if default is not None:
            unit[:] = (default + 1) / 2
        for group, columns in groups:
            system = System(group, [self.layout.columns[d] for d in columns])
            unit[:, columns] = system.solve(unit[:, columns])
        return 2 * unit - 1

    def _refuse_undecided(self, decided: set[int]) -> None:
        pairs = enumerate(zip(self.layout.draws, self.layout.columns, strict=True))
        free = [draw for d, (draw, column) in pairs if d not in decided and column.span != 0]
        if free:
            names = ", ".join(f"{draw.name} (line {draw.place.line})" for draw in free)
            hint = "ask for more, or give default=θ for the rest"
            raise ScenicError("value", f"nothing that is asked of the scene decides {names}", free[0].place, hint=hint)

    def _targets(self, key: Any, asked: Any) -> Iterator[Target]:
        """Yield what is asked of an object (its index or label), parameter or draw."""
        if key not in self.known:
            names = [name for name in self.known if isinstance(name, str)]
            hint = near(str(key), names) or f"it has {', '.join(names)}"
            raise ScenicError("name", f"{self.layout.file} has no object, parameter or draw {key!r}", hint=hint)
        value, place = self.known[key]
        if not isinstance(value, Instance):
            yield from targets_of(key, value, asked, place)
            return
        title = value.title()
        if not isinstance(asked, Mapping):
            parts = elements(asked)
            if len(parts) not in (2, 3):
                raise ScenicError("type", f"{title} takes (x, y) or (x, y, heading), not {asked!r}", place)
            asked = {"position": tuple(parts[:2])} | dict(zip(("heading",), parts[2:], strict=False))
        for name, part in asked.items():
            if name not in value.properties:
                hint = near(str(name), value.properties)
                raise ScenicError("name", f"{title} has no property {name!r}", place, hint=hint)
            yield from targets_of(f"{title} the {name}", value.properties[name], part, place)


def targets_of(what: str, value: Value, asked: Any, place: SourceSpan) -> list[Target]:
    """Return what is asked of a number or text, or of both coordinates of a vector."""
    parts = [(value, asked)]
    if isinstance(value, Vector) and len(elements(asked)) == 2:
        parts = list(zip((value.x, value.y), elements(asked), strict=True))
    targets = [Target(what, number, np.atleast_1d(wanted), place) for number, wanted in parts]
    for target in targets:
        kinds = {"number": "biuf", "truth": "b", "text": "OU"}.get(kind_of(target.value), "")
        if target.asked.ndim > 1 or target.asked.dtype.kind not in kinds:
            raise ScenicError("type", f"{what} cannot be {asked!r}", place)
        if target.asked.dtype.kind == "f" and not np.isfinite(target.asked).all():
            raise ScenicError("value", f"{what} cannot be a number that is not finite", place)
    return targets


def elements(asked: Any) -> Any:
    """Return the parts of what is asked: columns of an array [N, K], or what a list holds; () of a plain value."""
    if isinstance(asked, np.ndarray):
        return asked.T if asked.ndim in (1, 2) else ()
    return asked if isinstance(asked, list | tuple) else ()


# ------------------------------------------------------------ equations


def groups_of(targets: list[Target], columns: Sequence[ThetaColumn]) -> list[tuple[list[Target], list[int]]]:
    """Return the targets that share columns, directly or through others, and these columns' indices."""
    index = {id(column): d for d, column in enumerate(columns)}
    groups: list[tuple[list[Target], set[Any]]] = []
    for target in targets:
        group, shared = [target], {target.what, *(index[id(column)] for column in columns_of(target.value))}
        for other in [known for known in groups if known[1] & shared]:
            groups.remove(other)
            group, shared = [*other[0], *group], other[1] | shared
        groups.append((group, shared))
    return [(group, sorted(d for d in shared if isinstance(d, int))) for group, shared in groups]


class System:
    """C columns of θ that are decided together, and the W targets that depend on them."""

    def __init__(self, targets: list[Target], columns: list[ThetaColumn]) -> None:
        self.targets = targets
        self.tape = Tape([each.value for each in targets if isinstance(each.value, RandomExpr)], columns, 10**9)
        self.offset = np.array([column.offset for column in columns])
        self.span = np.array([column.span for column in columns])

    def values(self, unit: np.ndarray) -> list[Any]:
        """Return what the targets are at unit [M, C]: W arrays [M], or values that never vary."""
        with np.errstate(all="ignore"):
            registers = self.tape.run((self.offset + unit * self.span).T)
        values = [each.value for each in self.targets]
        return [registers[self.tape.slot(value)] if isinstance(value, RandomExpr) else value for value in values]

    def gaps(self, values: list[Any], rows: np.ndarray) -> np.ndarray:
        """Return by how much values miss what is asked in some rows [M]: [M, W]; texts by 1."""
        gaps = np.empty((len(rows), len(values)))
        for k, (value, target) in enumerate(zip(values, self.targets, strict=True)):
            asked = target.asked[rows % len(target.asked)]
            if asked.dtype.kind in "OU":
                gaps[:, k] = np.asarray(value) != asked
                continue
            gap = np.asarray(value, dtype=float) - asked
            gap = gap - TURN * np.rint(gap / TURN) if target.what.endswith(" the heading") else gap
            gaps[:, k] = np.nan_to_num(gap / np.maximum(1.0, np.abs(asked)), nan=1e9, posinf=1e9, neginf=-1e9)
        return gaps

    def solve(self, start: np.ndarray) -> np.ndarray:
        """Return unit [N, C] that gives what is asked, near the start if possible; else raise ScenicError."""
        unit, gaps = self._descend(start, np.arange(len(start)))
        missed = np.flatnonzero(worst(gaps) > CLOSE)
        if len(missed) and len(self.span):
            scan = np.random.default_rng(0).uniform(size=(SCAN, len(self.span)))
            values = self.values(scan)
            far = [worst(self.gaps(values, np.full(SCAN, row))) for row in missed]
            nearest = np.argsort(far, axis=1, kind="stable")[:, :STARTS]
            found, there = self._descend(scan[nearest.ravel()], np.repeat(missed, STARTS))
            best = worst(there).reshape(-1, STARTS).argmin(axis=1) + STARTS * np.arange(len(missed))
            better = worst(there[best]) < worst(gaps[missed])
            unit[missed[better]], gaps[missed[better]] = found[best[better]], there[best[better]]
        if (worst(gaps) > CLOSE).any():
            raise self._unmet(unit, gaps)
        return unit

    def _descend(self, unit: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return where damped steps of least squares lead from unit [M, C], and the gaps [M, W] there."""
        unit, gaps = unit.copy(), self.gaps(self.values(unit), rows)
        reach = np.ones(len(unit))  # of a step, cut where it leads astray
        for _ in range(ROUNDS if len(self.span) else 0):
            at = np.flatnonzero((worst(gaps) > 1e-13) & (reach > 1e-4))
            if not len(at):
                break
            trial = np.clip(unit[at] - reach[at, None] * self._step(unit[at], gaps[at], rows[at]), 0.0, 1.0)
            there = self.gaps(self.values(trial), rows[at])
            better = np.square(there).sum(axis=1) < np.square(gaps[at]).sum(axis=1)
            unit[at[better]], gaps[at[better]] = trial[better], there[better]
            reach[at] = np.where(better, np.minimum(2 * reach[at], 1.0), reach[at] / 4)
        return unit, gaps

    def _step(self, unit: np.ndarray, gaps: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return the shortest step [M, C] of least squares, from differences towards the middle of [0, 1]."""
        slope = np.empty((*gaps.shape, unit.shape[1]))  # [M, W, C]
        for c, nudge in enumerate(np.where(unit > 0.5, -NUDGE, NUDGE).T):
            moved = unit.copy()
            moved[:, c] += nudge
            slope[:, :, c] = (self.gaps(self.values(moved), rows) - gaps) / nudge[:, None]
        return (np.linalg.pinv(slope, rcond=1e-9) @ gaps[:, :, None])[:, :, 0]

    def _unmet(self, unit: np.ndarray, gaps: np.ndarray) -> ScenicError:
        """Return the error for the first scene that is not met: its first value, and the nearest that was found."""
        row = int(np.argmax(worst(gaps) > CLOSE))
        first = self.targets[int(np.argmin(np.abs(gaps[row]) <= CLOSE))]
        pairs = zip(self.targets, self.values(unit[[row]]), strict=True)
        same = [(target.asked[row % len(target.asked)], value) for target, value in pairs if target.what == first.what]
        asked, nearest = (shown(values) for values in zip(*same, strict=True))
        which = f" in scene {row}" if len(unit) > 1 else ""
        hint = f"the nearest that was found is {nearest}" if len(self.span) else f"the program fixes it at {nearest}"
        return ScenicError("value", f"found no θ that gives {first.what} {asked}{which}", first.place, hint=hint)


def worst(gaps: np.ndarray) -> np.ndarray:
    """Return the largest of the gaps [M, W] in each row."""
    return np.abs(gaps).max(axis=1)


def shown(parts: Sequence[Any]) -> str:
    """Return a value, or the two coordinates of a place, in one scene."""
    values = [np.ravel(part)[0] for part in parts]
    texts = [value if isinstance(value, str) else f"{value:g}" for value in values]
    return f"({' @ '.join(texts)})" if len(texts) == 2 else texts[0]
