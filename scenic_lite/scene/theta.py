"""From a scene back to θ: what is asked is compared with what the tape gives, and θ is moved until the two agree.

Placements are affine in θ nearly everywhere, so that one step of least squares on a numerical Jacobian mostly does;
a coarse scan of θ gives further starts, for choices and curved regions. Every answer is verified; what is not met, or
not decided by what is asked, is refused. Read next: `scene.scenes`, whose plans read a tape.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from scenic_lite.core.types import BehaviorCall, Instance, RandomChoice, near, randoms_in
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.scene.naming import Draw, ThetaLayout
from scenic_lite.scene.scenes import Planner, Scenes
from scenic_lite.values.formulas import TURN
from scenic_lite.values.geometry import Vector
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, columns_of, is_number, kind_of

CLOSE = 1e-6  # relative, from 1 on: two values that agree so far are the same
SCAN = 4096  # θ at which everything is computed once
STARTS = 8  # of these, the nearest to a scene, from which steps lead on
ROUNDS = 60  # steps from one start
NUDGE = 1e-7  # of [0, 1], for derivatives
LISTED = 8  # draws, in one message


class Subject(NamedTuple):
    """What can be asked of: the objects of a program, its parameters and its draws."""

    file: str
    objects: Sequence[Instance]
    params: Mapping[str, Value]
    param_places: Mapping[str, SourceSpan]
    layout: ThetaLayout


class Target(NamedTuple):
    """One plain value of the scenes: `value` gives it, `asked` [N] is what it shall be (nan: anything)."""

    title: str  # of whom, and `part` what, for messages
    part: str
    value: Value
    asked: Any
    place: SourceSpan


def theta_of(subject: Subject, scenes: Scenes | Mapping[Any, Any], default: np.ndarray | None) -> np.ndarray:
    """Find theta [N, D] of some scenes; `default` [1, D] or [N, D] decides the draws of which nothing is asked.

    Raises ScenicError naming the draws that nothing decides, or the value that is not met.
    """
    targets = list(targets_of_scenes(subject, scenes) if isinstance(scenes, Scenes) else targets_of(subject, scenes))
    lengths = sorted({len(target.asked) for target in targets} - {1})
    if len(lengths) > 1:
        message = f"the arrays that describe scenes have different lengths: {' and '.join(map(str, lengths))}"
        raise ScenicError("value", message)
    count = lengths[0] if lengths else 1
    if default is not None and len(default) not in (1, count):
        raise ValueError(f"default must be one row of theta or {count} of them, not {len(default)}")
    targets = [target._replace(asked=np.broadcast_to(target.asked, count)) for target in targets]
    groups = groups_of(targets, subject.layout.columns)
    decided = {d for _, columns in groups for d in columns}
    free = [d for d, column in enumerate(subject.layout.columns) if d not in decided and column.span != 0]
    if default is None and free:
        raise undetermined([subject.layout.draws[d] for d in free])
    unit = np.full((count, len(subject.layout.columns)), 0.5)  # [N, D], in [0, 1]
    if default is not None:
        unit[:] = (default + 1) / 2
    for group, columns in groups:
        system = System(group, [subject.layout.columns[d] for d in columns], subject.objects)
        unit[:, columns] = system.solve(unit[:, columns])
    return 2 * unit - 1


def undetermined(draws: list[Draw]) -> ScenicError:
    names = [f"{draw.name} (line {draw.place.line})" for draw in draws[:LISTED]]
    more = [f"{len(draws) - LISTED} more"] if len(draws) > LISTED else []
    message = f"nothing that is asked of the scene decides {', '.join(names + more)}"
    return ScenicError("value", message, draws[0].place, hint="ask for more, or give default=θ for the rest")


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


# ------------------------------------------------------------ what is asked


def targets_of_scenes(subject: Subject, scenes: Scenes) -> Iterator[Target]:
    """Yield everything that scenes hold."""
    count = scenes.positions.shape[1]
    if count != len(subject.objects):
        message = f"{subject.file} has {len(subject.objects)} objects, and these scenes have {count}"
        raise ScenicError("value", message)
    for i, instance in enumerate(subject.objects):
        held = {name: values[i] for name, values in scenes.properties.items() if name in instance.properties}
        held |= {"position": scenes.positions[:, i], "heading": scenes.headings[:, i]}
        yield from targets_of_object(subject, instance, held | {"behavior": scenes.behavior_arguments[i] or {}})
    for name, value in scenes.params.items():
        if name in subject.params:
            yield from leaves(subject, Target("", name, subject.params[name], value, subject.param_places[name]))


def targets_of(subject: Subject, description: Mapping[Any, Any]) -> Iterator[Target]:
    """Yield what a person asks of objects, parameters and draws. Raises ScenicError for a name that is none of them."""
    draws = {draw.name: column.shown for draw, column in zip(subject.layout.draws, subject.layout.columns, strict=True)}
    places = {draw.name: draw.place for draw in subject.layout.draws} | dict(subject.param_places)
    names = draws | dict(subject.params)
    for key, asked in description.items():
        at = object_named(subject, key, names)
        if at is None:
            targets = leaves(subject, Target(str(key), "value", names[key], asked, places[key]))
        else:
            instance = subject.objects[at]
            asked = asked if isinstance(asked, Mapping) else stance_of(instance, asked)
            targets = targets_of_object(subject, instance, asked)
        for target in targets:
            if target.asked.dtype.kind == "f" and not np.isfinite(target.asked).all():
                raise ScenicError("value", f"what is asked of {key} holds a number that is not finite")
            yield target


def targets_of_object(subject: Subject, instance: Instance, asked: Mapping[str, Any]) -> Iterator[Target]:
    """Yield what is asked of an object's properties, and of the arguments of its behavior."""
    for name, data in asked.items():
        known, parts = instance.properties, {name: data}
        if name == "behavior" and isinstance(data, Mapping):
            behavior = known.get(name)
            known, parts = behavior.arguments if isinstance(behavior, BehaviorCall) else {}, dict(data)
        for part, wish in parts.items():
            if part not in known:
                what = "property" if known is instance.properties else "argument of a behavior"
                message = f"{instance.title()} has no {what} {part!r}"
                raise ScenicError("name", message, instance.place, hint=near(str(part), known))
            yield from leaves(subject, Target(instance.title(), part, known[part], wish, instance.place))


def object_named(subject: Subject, key: Any, others: Mapping[str, Value]) -> int | None:
    """Return an object's index by its index, label, `ego` or class, if the only one of it; None for `others`."""
    titles = [instance.title() for instance in subject.objects]
    if isinstance(key, int | np.integer):
        if not 0 <= key < len(titles):
            raise ScenicError("name", f"{subject.file} has {len(titles)} objects, and no object {key}")
        return int(key)
    if key in titles or key in others:
        return titles.index(key) if key in titles else None
    alike = [i for i, instance in enumerate(subject.objects) if key in [cls.name for cls in instance.cls.lineage()]]
    if len(alike) > 1:
        hint = f"say {', '.join(titles[i] for i in alike)}"
        raise ScenicError("name", f"{subject.file} has {len(alike)} objects of the class {key}", hint=hint)
    if alike or (key == "ego" and titles):
        return alike[0] if alike else 0
    hint = near(key, [*titles, *others]) if isinstance(key, str) else ""
    message = f"{subject.file} has no object, parameter or draw {key!r}"
    raise ScenicError("name", message, hint=hint or f"it has {', '.join([*titles, *others])}")


def stance_of(instance: Instance, asked: Any) -> dict[str, Any]:
    """Return what (x, y) or (x, y, heading) ask, each a number or an array [N]; or an array [N, 2] or [N, 3]."""
    parts = asked.T if isinstance(asked, np.ndarray) and asked.ndim == 2 else asked
    if not isinstance(parts, list | tuple | np.ndarray) or len(parts) not in (2, 3):
        raise ScenicError("type", f"{instance.title()} takes (x, y) or (x, y, heading), not {asked!r}", instance.place)
    return {"position": tuple(parts[:2])} | ({"heading": parts[2]} if len(parts) == 3 else {})


def leaves(subject: Subject, target: Target) -> Iterator[Target]:
    """Yield the plain values of which a value of any structure is made; regions and the like are not asked for."""
    value, asked = target.value, target.asked
    pairs: list[tuple[Value, Any]] = []
    if isinstance(value, Instance) and not any(value is instance for instance in subject.objects):
        pairs = [(value.properties["position"], asked)]
    elif isinstance(value, Vector):
        parts = asked.T if isinstance(asked, np.ndarray) and asked.ndim == 2 else asked
        if not isinstance(parts, list | tuple | np.ndarray) or len(parts) < 2:
            raise ScenicError("type", f"{target.part} takes (x, y), not {asked!r}", target.place)
        pairs = [(value.x, parts[0]), (value.y, parts[1])]
    elif isinstance(value, dict) and isinstance(asked, Mapping):
        pairs = [(part, asked[key]) for key, part in value.items() if key in asked]
    elif isinstance(value, list | tuple) and isinstance(asked, list | tuple) and len(value) == len(asked):
        pairs = list(zip(value, asked, strict=True))
    elif isinstance(value, RandomExpr | RandomChoice | str | bool) or is_number(value):
        yield target._replace(asked=array_of(target))
    for part, data in pairs:
        yield from leaves(subject, target._replace(value=part, asked=data))


def array_of(target: Target) -> np.ndarray:
    """Return what is asked of a plain value, as an array [N] or [1]."""
    asked, numeric = target.asked, kind_of(target.value) == "number"
    array = np.array([asked, None], dtype=object)[:-1] if isinstance(asked, list | tuple | str) else np.asarray(asked)
    if numeric and array.dtype.kind not in "biuf":
        raise ScenicError("type", f"{target.part} is a number, and cannot be {asked!r}", target.place)
    if array.ndim > 1:
        raise ScenicError("type", f"{target.part} takes a number or an array [N], not {array.shape}", target.place)
    return np.atleast_1d(array)


# ------------------------------------------------------------ equations


class System:
    """C columns of θ that are decided together, and the W targets that depend on them."""

    def __init__(self, targets: list[Target], columns: list[ThetaColumn], objects: Sequence[Instance]) -> None:
        self.targets = targets
        self.tape = Tape([node for target in targets for node in randoms_in(target.value)], columns, 10**9)
        planner = Planner(self.tape, list(objects))
        self.readers = [planner.reader(target.value) for target in targets]
        self.offset = np.array([column.offset for column in columns])
        self.span = np.array([column.span for column in columns])

    def values(self, unit: np.ndarray) -> list[Any]:
        """Return what the targets are at unit [M, C]: W arrays [M], or values that never vary."""
        with np.errstate(all="ignore"):
            registers = self.tape.run((self.offset + unit * self.span).T)
            return [reader(registers, len(unit)) for reader in self.readers]

    def gaps(self, unit: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return by how much unit [M, C] misses what is asked in some rows [M]: [M, W]."""
        return self._misses(self.values(unit), rows)

    def _misses(self, values: list[Any], rows: np.ndarray) -> np.ndarray:
        pairs = zip(values, self.targets, strict=True)
        parts = [gap(value, target.asked[rows], target.part) for value, target in pairs]
        return np.stack([np.broadcast_to(part, len(rows)) for part in parts], axis=1)

    def solve(self, start: np.ndarray) -> np.ndarray:
        """Return unit [N, C] that gives what is asked, near the start if possible; else raise ScenicError."""
        rows = np.arange(len(start))
        unit, error = self._descend(start, rows)
        missed = rows[~(error <= CLOSE)]
        if len(missed) and start.shape[1]:
            starts = self._nearest(missed)
            for k in range(STARTS):
                again, there = self._descend(starts[:, k], missed)
                better = there < error[missed]
                unit[missed[better]], error[missed[better]] = again[better], there[better]
                left = error[missed] > CLOSE
                missed, starts = missed[left], starts[left]
        if len(missed):
            raise self._unmet(unit, int(missed[0]))
        return unit

    def _descend(self, start: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return where Gauss-Newton leads from start [M, C], and the largest gap [M] there."""
        unit = start.copy()
        value = self.gaps(unit, rows)  # [M, W]
        reach = np.ones(len(unit))  # of a step, halved where it leads astray
        for _ in range(ROUNDS if unit.shape[1] else 0):
            active = np.flatnonzero((np.abs(value).max(axis=1) > 1e-15) & (reach > 1e-4))
            if not len(active):
                break
            step = self._step(unit[active], value[active], rows[active])
            trial = np.clip(unit[active] - reach[active, None] * step, 0.0, 1.0)
            there = self.gaps(trial, rows[active])
            better = np.square(there).sum(axis=1) < np.square(value[active]).sum(axis=1)
            unit[active[better]], value[active[better]] = trial[better], there[better]
            reach[active] = np.where(better, np.minimum(2 * reach[active], 1.0), reach[active] / 4)
        return unit, np.nan_to_num(np.abs(value).max(axis=1), nan=np.inf)

    def _step(self, unit: np.ndarray, value: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return the shortest step [M, C] of least squares; columns at an end of [0, 1] stay, others make up for it."""
        nudge = np.where(unit > 0.5, -NUDGE, NUDGE)
        slope = np.empty((*value.shape, unit.shape[1]))  # [M, W, C]
        for c in range(unit.shape[1]):
            moved = unit.copy()
            moved[:, c] += nudge[:, c]
            slope[:, :, c] = (self.gaps(moved, rows) - value) / nudge[:, c, None]
        slope, value = (np.nan_to_num(part, posinf=0.0, neginf=0.0) for part in (slope, value))
        step = (np.linalg.pinv(slope, rcond=1e-9) @ value[:, :, None])[:, :, 0]
        blocked = ((unit <= 0) & (step > 0)) | ((unit >= 1) & (step < 0))
        if blocked.any():
            slope[np.broadcast_to(blocked[:, None], slope.shape)] = 0.0
            step = (np.linalg.pinv(slope, rcond=1e-9) @ value[:, :, None])[:, :, 0]
        return step

    def _nearest(self, rows: np.ndarray) -> np.ndarray:
        """Return the points of a coarse scan that come nearest to what is asked in some rows: [M, STARTS, C]."""
        scan = np.random.default_rng(0).uniform(size=(SCAN, len(self.offset)))
        values = self.values(scan)
        best = []
        for row in rows:
            far = np.abs(self._misses(values, np.full(SCAN, row))).max(axis=1)  # [SCAN]
            best.append(scan[np.argsort(np.nan_to_num(far, nan=np.inf), kind="stable")[:STARTS]])
        return np.stack(best)

    def _unmet(self, unit: np.ndarray, row: int) -> ScenicError:
        """Return the error for one scene: the first value that is not met, and the nearest that was found."""
        missed = np.abs(self.gaps(unit[[row]], np.array([row])))[0]
        first = self.targets[int(np.flatnonzero(~(missed <= CLOSE))[0])]
        pairs = zip(self.targets, self.values(unit[[row]]), strict=True)
        family = [(target.asked[row], value) for target, value in pairs if target[:2] == first[:2]]
        asked, nearest = (shown(values) for values in zip(*family, strict=True))
        which = f" in scene {row}" if len(unit) > 1 else ""
        hint = f"the nearest that was found is {nearest}" if self.span.size else f"the program fixes it at {nearest}"
        what = f"{first.title} the {first.part}" if first.title else first.part
        return ScenicError("value", f"found no θ that gives {what} {asked}{which}", first.place, hint=hint)


def shown(parts: Sequence[Any]) -> str:
    """Return a value, or the two coordinates of a place, in one scene."""
    values = [np.ravel(part)[0] if isinstance(part, np.ndarray) else part for part in parts]
    texts = [f"{value:g}" if isinstance(value, int | float | np.number) else str(value) for value in values]
    return f"({' @ '.join(texts)})" if len(texts) == 2 else ", ".join(texts)


def gap(value: Any, asked: Any, part: str) -> Any:
    """Return by how much values [M] miss what is asked; 1 where they are no numbers and not the same."""
    value = np.asarray(value)
    if value.dtype.kind in "biuf" and asked.dtype.kind in "biuf":
        gaps = value.astype(float) - asked
        if part == "heading":
            gaps = gaps - TURN * np.rint(gaps / TURN)
        return np.where(np.isnan(np.asarray(asked, dtype=float)), 0.0, gaps / np.maximum(1.0, np.abs(asked)))
    pairs = np.broadcast(np.atleast_1d(value), asked)
    return np.array([0.0 if same(a, b) else 1.0 for a, b in pairs])


def same(a: Any, b: Any) -> bool:
    """Return whether two values agree, numbers up to rounding."""
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if is_number(a) and is_number(b):
        return abs(a - b) <= CLOSE * max(1.0, abs(b))
    return bool(a == b)
