"""From a scene back to θ: what is asked is compared with what the tape gives, and θ is moved until the two agree.

Placements are affine in θ nearly everywhere, so that one step of least squares on a numerical Jacobian mostly does;
a coarse scan of θ gives further starts, for choices and curved regions. Every answer is verified; what is not met, or
not decided by what is asked, is refused. Read next: `scene.scenes`, whose readers read a tape.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.state import LoadState
from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice, near, randoms_in
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene.naming import ThetaLayout
from scenic_lite.scene.scenes import Planner, Scenes
from scenic_lite.values.formulas import TURN
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, columns_of, is_number, kind_of

CLOSE = 1e-6  # relative, from 1 on: two numbers that agree so far are the same
SCAN = 4096  # θ at which everything is computed once
STARTS = 8  # of these, the nearest to a scene, from which steps lead on
ROUNDS = 60  # steps from one start
NUDGE = 1e-7  # of [0, 1], for derivatives
LISTED = 8  # draws, in one message


class Target(NamedTuple):
    """A value of the scenes and what it shall be; once it is `plain`, `asked` is an array [N] or [1] (nan: anything).

    `title`: of whom, "" for a parameter or draw; `part`: what.
    """

    title: str
    part: str
    value: Value
    asked: Any
    place: SourceSpan


class Inverse:
    """The way back from the scenes of one program: what can be asked of them, and the θ that gives it."""

    def __init__(self, state: LoadState, objects: Sequence[Instance], layout: ThetaLayout) -> None:
        self.file, self.objects, self.layout = layout.file, objects, layout
        self.targets = {
            draw.name: Target("", draw.name, column.shown, None, draw.place)
            for draw, column in zip(layout.draws, layout.columns, strict=True)
        }
        for name, value in state.params.items():
            self.targets[name] = Target("", name, value, None, state.param_places[name])

    def theta(self, scenes: Scenes | Mapping[Any, Any], default: np.ndarray | None) -> np.ndarray:
        """Find theta [N, D] of some scenes; `default` [1, D] or [N, D] decides the draws of which nothing is asked.

        Raises ScenicError naming the draws that nothing decides, or the value that is not met.
        """
        asked = self._held(scenes) if isinstance(scenes, Scenes) else self._described(scenes)
        targets = [part for target in asked for part in self._plain(target)]
        for target in targets if isinstance(scenes, Mapping) else []:
            if target.asked.dtype.kind == "f" and not np.isfinite(target.asked).all():
                whose = target.title or target.part
                raise ScenicError("value", f"what is asked of {whose} holds a number that is not finite")
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
            system = System(group, [self.layout.columns[d] for d in columns], self.objects)
            unit[:, columns] = system.solve(unit[:, columns])
        return 2 * unit - 1

    def _refuse_undecided(self, decided: set[int]) -> None:
        pairs = enumerate(zip(self.layout.draws, self.layout.columns, strict=True))
        free = [draw for d, (draw, column) in pairs if d not in decided and column.span != 0]
        if free:
            names = [f"{draw.name} (line {draw.place.line})" for draw in free[:LISTED]]
            names += [f"{len(free) - LISTED} more"] if len(free) > LISTED else []
            message = f"nothing that is asked of the scene decides {', '.join(names)}"
            raise ScenicError("value", message, free[0].place, hint="ask for more, or give default=θ for the rest")

    def _held(self, scenes: Scenes) -> Iterator[Target]:
        """Yield everything that scenes hold."""
        count = scenes.positions.shape[1]
        if count != len(self.objects):
            message = f"{self.file} has {len(self.objects)} objects, and these scenes have {count}"
            raise ScenicError("value", message)
        for i, instance in enumerate(self.objects):
            held = {name: values[i] for name, values in scenes.properties.items() if name in instance.properties}
            held |= {"position": scenes.positions[:, i], "heading": scenes.headings[:, i]}
            held["behavior"] = scenes.behavior_arguments[i]
            yield Target(instance.title(), "property", instance, held, instance.place)
        for name in scenes.params.keys() & self.targets.keys():
            yield self.targets[name]._replace(asked=scenes.params[name])

    def _described(self, description: Mapping[Any, Any]) -> Iterator[Target]:
        """Yield what a person asks of objects, parameters and draws. Raises ScenicError for what is none of them."""
        for key, asked in description.items():
            instance = self._object(key)
            if instance is None:
                yield self.targets[key]._replace(asked=asked)
                continue
            if not isinstance(asked, Mapping):
                parts = elements(asked)
                if len(parts) not in (2, 3):
                    message = f"{instance.title()} takes (x, y) or (x, y, heading), not {asked!r}"
                    raise ScenicError("type", message, instance.place)
                asked = {"position": tuple(parts[:2])} | ({"heading": parts[2]} if len(parts) == 3 else {})
            yield Target(instance.title(), "property", instance, asked, instance.place)

    def _object(self, key: Any) -> Instance | None:
        """Return an object by its index, label, `ego` or class, if the only one of it; None for a parameter or draw."""
        titles = [instance.title() for instance in self.objects]
        if isinstance(key, int | np.integer):
            if not 0 <= key < len(titles):
                raise ScenicError("name", f"{self.file} has {len(titles)} objects, and no object {key}")
            return self.objects[int(key)]
        if key in titles or key in self.targets:
            return self.objects[titles.index(key)] if key in titles else None
        alike = [each for each in self.objects if key in [cls.name for cls in each.cls.lineage()]]
        if len(alike) > 1:
            hint = f"say {', '.join(each.title() for each in alike)}"
            raise ScenicError("name", f"{self.file} has {len(alike)} objects of the class {key}", hint=hint)
        if alike or (key == "ego" and titles):
            return [*alike, *self.objects][0]
        known = [*titles, *self.targets]
        hint = (near(key, known) if isinstance(key, str) else "") or f"it has {', '.join(known)}"
        raise ScenicError("name", f"{self.file} has no object, parameter or draw {key!r}", hint=hint)

    def _plain(self, target: Target) -> Iterator[Target]:
        """Yield the targets of the plain values that a value is made of; regions and the like are not asked for."""
        value, asked = target.value, target.asked
        if isinstance(value, Instance) and not isinstance(asked, Mapping):
            value = None if any(value is each for each in self.objects) else value.properties["position"]
        elif isinstance(value, Instance):
            value = value.properties
        elif isinstance(value, BehaviorCall):
            target, value = target._replace(part="argument of a behavior"), value.arguments
        if isinstance(value, dict) and isinstance(asked, Mapping):
            for name, part in asked.items():
                if name not in value:
                    message = f"{target.title} has no {target.part} {name!r}"
                    raise ScenicError("name", message, target.place, hint=near(str(name), value))
                yield from self._plain(target._replace(part=name, value=value[name], asked=part))
        elif isinstance(value, Vector | list | tuple):
            values = [value.x, value.y] if isinstance(value, Vector) else value
            if len(values) != len(elements(asked)):
                message = f"{target.part} is made of {len(values)} values, and cannot be {asked!r}"
                raise ScenicError("type", message, target.place)
            for each, part in zip(values, elements(asked), strict=True):
                yield from self._plain(target._replace(value=each, asked=part))
        elif isinstance(value, RandomExpr | RandomChoice | str | bool) or is_number(value):
            yield target._replace(value=value, asked=array_of(target))


def elements(asked: Any) -> Any:
    """Return the parts of what is asked: columns of an array [N, K], or what a list holds; () of a plain value."""
    if isinstance(asked, np.ndarray):
        return asked.T if asked.ndim in (1, 2) else ()
    return asked if isinstance(asked, list | tuple) else ()


def array_of(target: Target) -> np.ndarray:
    """Return what is asked of a plain value, as an array [N] or [1]."""
    asked = target.asked
    array = np.array([asked, None], dtype=object)[:-1] if isinstance(asked, list | tuple) else np.asarray(asked)
    if kind_of(target.value) == "number" and array.dtype.kind not in "biuf":
        raise ScenicError("type", f"{target.part} is a number, and cannot be {asked!r}", target.place)
    if array.ndim > 1:
        raise ScenicError("type", f"{target.part} takes a number or an array [N], not {array.shape}", target.place)
    return np.atleast_1d(array)


# ------------------------------------------------------------ equations


def groups_of(targets: list[Target], columns: Sequence[ThetaColumn]) -> list[tuple[list[Target], list[int]]]:
    """Return the targets that share columns, directly or through others, and these columns' indices."""
    index = {id(column): d for d, column in enumerate(columns)}
    groups: list[tuple[list[Target], set[Any]]] = []
    for target in targets:
        group, shared = [target], set[Any](index[id(column)] for column in columns_of(*randoms_in(target.value)))
        shared.add((target.title, target.part))  # so that both coordinates of a position are in one message
        for other in [known for known in groups if known[1] & shared]:
            groups.remove(other)
            group, shared = [*other[0], *group], other[1] | shared
        groups.append((group, shared))
    return [(group, sorted(d for d in shared if isinstance(d, int))) for group, shared in groups]


class System:
    """C columns of θ that are decided together, and the W targets that depend on them."""

    def __init__(self, targets: list[Target], columns: list[ThetaColumn], objects: Sequence[Instance]) -> None:
        self.targets = targets
        self.tape = Tape([node for target in targets for node in randoms_in(target.value)], columns, 10**9)
        planner = Planner(self.tape, objects)
        self.readers = [planner.reader(target.value) for target in targets]
        self.offset = np.array([column.offset for column in columns])
        self.span = np.array([column.span for column in columns])

    def values(self, unit: np.ndarray) -> list[Any]:
        """Return what the targets are at unit [M, C]: W arrays [M], or values that never vary."""
        with np.errstate(all="ignore"):
            registers = self.tape.run((self.offset + unit * self.span).T)
            return [reader(registers, len(unit)) for reader in self.readers]

    def gaps(self, values: list[Any], rows: np.ndarray) -> np.ndarray:
        """Return by how much values miss what is asked in some rows [M]: [M, W]."""
        pairs = zip(values, self.targets, strict=True)
        parts = [gap(value, target.asked[rows % len(target.asked)], target.part) for value, target in pairs]
        return np.stack([np.broadcast_to(part, len(rows)) for part in parts], axis=1)

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
            best = best[worst(there[best]) <= CLOSE]
            unit[missed[best // STARTS]], gaps[missed[best // STARTS]] = found[best], there[best]
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
        slope, gaps = (np.nan_to_num(part, posinf=0.0, neginf=0.0) for part in (slope, gaps))
        return (np.linalg.pinv(slope, rcond=1e-9) @ gaps[:, :, None])[:, :, 0]

    def _unmet(self, unit: np.ndarray, gaps: np.ndarray) -> ScenicError:
        """Return the error for the first scene that is not met: its first value, and the nearest that was found."""
        row = int(np.argmax(worst(gaps) > CLOSE))
        first = self.targets[int(np.argmin(np.abs(gaps[row]) <= CLOSE))]
        pairs = zip(self.targets, self.values(unit[[row]]), strict=True)
        same = [(target.asked[row % len(target.asked)], value) for target, value in pairs if target[:2] == first[:2]]
        asked, nearest = (shown(values) for values in zip(*same, strict=True))
        which = f" in scene {row}" if len(unit) > 1 else ""
        hint = f"the nearest that was found is {nearest}" if len(self.span) else f"the program fixes it at {nearest}"
        what = f"{first.title} the {first.part}" if first.title else first.part
        return ScenicError("value", f"found no θ that gives {what} {asked}{which}", first.place, hint=hint)


def worst(gaps: np.ndarray) -> np.ndarray:
    """Return the largest of the gaps [M, W] in each row."""
    return np.nan_to_num(np.abs(gaps).max(axis=1), nan=np.inf)


def gap(value: Any, asked: np.ndarray, part: str) -> Any:
    """Return by how much values [M] miss what is asked; 1 where they are no numbers and not the same."""
    value = np.asarray(value)
    if value.dtype.kind in "biuf" and asked.dtype.kind in "biuf":
        gaps = value.astype(float) - asked
        if part == "heading":
            gaps = gaps - TURN * np.rint(gaps / TURN)
        return np.where(np.isnan(asked.astype(float)), 0.0, gaps / np.maximum(1.0, np.abs(asked)))
    return np.array([0.0 if a == b else 1.0 for a, b in np.broadcast(np.atleast_1d(value), asked)])


def shown(parts: Sequence[Any]) -> str:
    """Return a value, or the two coordinates of a place, in one scene."""
    values = [np.ravel(part)[0] if isinstance(part, np.ndarray) else part for part in parts]
    texts = [f"{value:g}" if isinstance(value, int | float | np.number) else str(value) for value in values]
    return f"({' @ '.join(texts)})" if len(texts) == 2 else ", ".join(texts)
