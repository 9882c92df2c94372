"""From a scene back to θ: a search for the θ whose scene agrees with a description.

Positions are affine in θ nearly everywhere, so one least-squares step with a numerical Jacobian usually suffices.
Random θ are further starting points for choices and curved regions. Every result is verified. A description that no θ
meets, or that does not determine θ, is rejected. Read next: `values.graph`, the tape.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.state import LoadState
from scenic_lite.core.types import Instance, near
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene.naming import ThetaLayout, titles_of_options
from scenic_lite.values.formulas import TURN
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, columns_of, kind_of

CLOSE = 1e-6  # tolerance of equality, relative for numbers above 1
STARTS = 4096, 8  # number of random θ, and number of those nearest to a scene that become starting points
ROUNDS = 60  # maximum number of steps from one starting point
NUDGE = 1e-7  # step of the numerical derivative in [0, 1]
KINDS = {"number": "biuf", "truth": "b", "text": "OU"}  # allowed array kinds in a description, by kind of value


class Target(NamedTuple):
    """A number or text of the scenes and its required value, an array [N] or [1]; `what` is like "ego the position"."""

    what: str
    value: Value
    asked: np.ndarray
    place: SourceSpan


def theta_of(
    state: LoadState,
    objects: Sequence[Instance],
    layout: ThetaLayout,
    description: Mapping[Any, Any],
    default: np.ndarray | None,
) -> np.ndarray:
    """Return theta [N, D] of the described scenes; `default` [1, D] or [N, D] sets all other draws.

    Raises ScenicError that names undetermined draws or the first value for which no θ was found.
    """
    drawn = list(zip(layout.draws, layout.columns, strict=True))
    known: dict[Any, tuple[Value, SourceSpan]]
    known = {name: (value, state.param_places[name]) for name, value in state.params.items()}
    known |= {draw.name: (column.shown, draw.place) for draw, column in drawn}  # the names of `describe`
    titles = {draw.name: titles_of_options(column.options) for draw, column in drawn if column.options}
    known |= {key: (instance, instance.place) for i, instance in enumerate(objects) for key in (i, instance.title())}
    for key in description.keys() - known.keys():
        names = [name for name in known if isinstance(name, str)]
        hint = near(str(key), names) or f"it has {', '.join(names)}"
        raise ScenicError("name", f"{layout.file} has no object, parameter or draw {key!r}", hint=hint)
    meant = {key: chosen(key, asked, titles[key]) if key in titles else asked for key, asked in description.items()}
    targets = [target for key, asked in meant.items() for target in targets_of(key, *known[key], asked)]
    lengths = sorted({len(target.asked) for target in targets} - {1}) or [1]
    if len(lengths) > 1:
        message = f"the arrays that describe scenes have different lengths: {' and '.join(map(str, lengths))}"
        raise ScenicError("value", message)
    if default is not None and len(default) not in (1, *lengths):
        raise ValueError(f"default must be one row of theta or {lengths[0]} of them, not {len(default)}")
    systems = systems_of(targets, layout.columns)
    if default is None:
        refuse_undecided(layout, {d for system in systems for d in system.at})
    unit = np.full((lengths[0], len(layout.columns)), 0.5)  # [N, D], in [0, 1]
    unit[:] = 0.5 if default is None else (default + 1) / 2
    for system in systems:
        unit[:, system.at] = system.solve(unit[:, system.at])
    return 2 * unit - 1


def chosen(what: str, asked: Any, titles: Sequence[str]) -> Any:
    """Return the indices of structured options, given by their titles or indices."""
    parts = asked if isinstance(asked, list | tuple | np.ndarray) else [asked]
    if all(isinstance(part, int | np.integer) for part in parts):
        return asked
    wrong = next((part for part in parts if not isinstance(part, str) or part not in titles), None)
    if wrong is not None:
        hint = near(str(wrong), titles) or f"its options are {', '.join(titles)}"
        raise ScenicError("value", f"{what} cannot be {wrong!r}", hint=hint)
    found = np.array([titles.index(part) for part in parts])
    return found if isinstance(asked, list | tuple | np.ndarray) else int(found[0])


def refuse_undecided(layout: ThetaLayout, decided: set[int]) -> None:
    """Raise ScenicError if there are undetermined draws."""
    pairs = enumerate(zip(layout.draws, layout.columns, strict=True))
    free = [draw for d, (draw, column) in pairs if d not in decided and column.span != 0]
    if free:
        names = ", ".join(f"{draw.name} (line {draw.place.line})" for draw in free)
        hint = "describe more, or give default=θ for the rest"
        raise ScenicError("value", f"the description of the scene does not determine {names}", free[0].place, hint=hint)


def targets_of(what: str, value: Value, place: SourceSpan, asked: Any) -> Iterator[Target]:
    """Yield the targets of a number, a text, or all parts of a vector or object."""
    parts = asked.T if isinstance(asked, np.ndarray) and asked.ndim in (1, 2) else asked
    several = len(parts) if isinstance(parts, np.ndarray | list | tuple) else 0
    if isinstance(value, Instance):
        title = value.title()
        if not isinstance(asked, Mapping):
            if several not in (2, 3):
                raise ScenicError("type", f"{title} takes (x, y) or (x, y, heading), not {asked!r}", place)
            asked = {"position": tuple(parts[:2])} | dict(zip(("heading",), parts[2:], strict=False))
        for name, part in asked.items():
            if name not in value.properties:
                hint = near(str(name), value.properties)
                raise ScenicError("name", f"{title} has no property {name!r}", place, hint=hint)
            yield from targets_of(f"{title} the {name}", value.properties[name], place, part)
        return
    pairs = (
        zip((value.x, value.y), parts, strict=True) if isinstance(value, Vector) and several == 2 else [(value, asked)]
    )
    for number, part in pairs:
        goal = np.atleast_1d(part)
        if goal.ndim > 1 or goal.dtype.kind not in KINDS.get(kind_of(number), ""):
            raise ScenicError("type", f"{what} cannot be {asked!r}", place)
        if goal.dtype.kind == "f" and not np.isfinite(goal).all():
            raise ScenicError("value", f"{what} cannot be a number that is not finite", place)
        yield Target(what, number, goal, place)


def systems_of(targets: Sequence[Target], columns: Sequence[ThetaColumn]) -> list[System]:
    """Return groups of targets that share columns, directly or indirectly, or belong to one position."""
    reads = np.array([[column in set(columns_of(goal.value)) for column in columns] for goal in targets], dtype=bool)
    whats = np.array([goal.what for goal in targets], dtype=object)
    linked, fewer = (reads @ reads.T) | (whats[:, None] == whats) if targets else reads, 0  # [W, W]
    while linked.sum() > fewer:
        fewer, linked = linked.sum(), linked @ linked
    groups = [np.flatnonzero(row).tolist() for k, row in enumerate(linked) if row.argmax() == k]
    return [System([targets[k] for k in group], columns, reads[group].any(axis=0)) for group in groups]


class System:
    """W targets and the C columns of θ, with indices `at`, that must be solved together."""

    def __init__(self, targets: Sequence[Target], columns: Sequence[ThetaColumn], read: Any) -> None:
        self.targets, self.at = targets, np.flatnonzero(read).tolist()
        own = [columns[d] for d in self.at]
        self.tape = Tape([target.value for target in targets if isinstance(target.value, RandomExpr)], own, 10**9)
        self.offset = np.array([column.offset for column in own])
        self.span = np.array([column.span for column in own])

    def values(self, unit: np.ndarray) -> list[Any]:
        """Return the values of the targets at unit [M, C]: W arrays [M] or fixed values."""
        with np.errstate(all="ignore"):
            registers = self.tape.run((self.offset + unit * self.span).T)
        values = [target.value for target in self.targets]
        return [registers[self.tape.slot(value)] if isinstance(value, RandomExpr) else value for value in values]

    def gaps(self, values: list[Any], rows: np.ndarray) -> np.ndarray:
        """Return the errors [M, W] of values in the given rows [M]; 1 for a wrong text."""
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
        """Return unit [N, C] that meets the targets, near the start if possible. Raises ScenicError on failure."""
        unit, gaps = self.descend(start, np.arange(len(start)))
        missed = np.flatnonzero(worst(gaps) > CLOSE)
        if len(missed) and len(self.at):
            scan = np.random.default_rng(0).uniform(size=(STARTS[0], len(self.at)))
            values = self.values(scan)
            far = [worst(self.gaps(values, np.full(len(scan), row))) for row in missed]
            for starts in np.argsort(far, axis=1, kind="stable")[:, : STARTS[1]].T:
                descended, there = self.descend(scan[starts], missed)
                better = worst(there) < worst(gaps[missed])
                unit[missed[better]], gaps[missed[better]] = descended[better], there[better]
        if (worst(gaps) > CLOSE).any():
            raise self.unmet(unit, gaps)
        return unit

    def descend(self, unit: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Take damped least-squares steps from unit [M, C]; return the end point and its gaps [M, W]."""
        unit, gaps = unit.copy(), self.gaps(self.values(unit), rows)
        reach = np.ones(len(unit))  # step size, reduced after an overshoot
        for _ in range(ROUNDS if len(self.at) else 0):
            at = np.flatnonzero((worst(gaps) > 1e-13) & (reach > 1e-4))
            if not len(at):
                break
            slope = np.empty((len(at), *gaps.shape[1:], unit.shape[1]))  # [M, W, C], by steps toward the middle
            for c, nudge in enumerate(np.where(unit[at] > 0.5, -NUDGE, NUDGE).T):
                moved = unit[at]
                moved[:, c] += nudge
                slope[:, :, c] = (self.gaps(self.values(moved), rows[at]) - gaps[at]) / nudge[:, None]
            step = (np.linalg.pinv(slope, rcond=1e-9) @ gaps[at, :, None])[:, :, 0]  # the shortest solution
            trial = np.clip(unit[at] - reach[at, None] * step, 0.0, 1.0)
            there = self.gaps(self.values(trial), rows[at])
            better = np.square(there).sum(axis=1) < np.square(gaps[at]).sum(axis=1)
            unit[at[better]], gaps[at[better]] = trial[better], there[better]
            reach[at] = np.where(better, np.minimum(2 * reach[at], 1.0), reach[at] / 4)
        return unit, gaps

    def unmet(self, unit: np.ndarray, gaps: np.ndarray) -> ScenicError:
        """Return the error for the first unmatched scene: its first unmatched value and the nearest value found."""
        row = int(np.argmax(worst(gaps) > CLOSE))
        what, _, _, place = self.targets[int(np.argmin(np.abs(gaps[row]) <= CLOSE))]
        pairs = zip(self.targets, self.values(unit[[row]]), strict=True)
        same = [(target.asked[row % len(target.asked)], value) for target, value in pairs if target.what == what]
        asked, nearest = (shown(values) for values in zip(*same, strict=True))
        which = f" in scene {row}" if len(unit) > 1 else ""
        hint = f"the nearest that was found is {nearest}" if len(self.at) else f"the program fixes it at {nearest}"
        return ScenicError("value", f"found no θ that gives {what} {asked}{which}", place, hint=hint)


def worst(gaps: np.ndarray) -> np.ndarray:
    """Return the largest of the gaps [M, W] in each row."""
    return np.abs(gaps).max(axis=1)


def shown(parts: Sequence[Any]) -> str:
    """Return the text of a value, or of the two coordinates of a position, in one scene."""
    values = [np.ravel(part)[0] for part in parts]
    texts = [value if isinstance(value, str) else f"{value:g}" for value in values]
    return f"({' @ '.join(texts)})" if len(texts) == 2 else texts[0]
