"""From a scene to the level that describes it: the inverse of `Program.instantiate`.

What is asked is carried back through the tape (`inversion`); what is left is searched for (`solver`); then the level is
made, and compared with what was asked. Read next: `inverse.wishes`, in which a scene is asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scenic_lite.core.scope import DrawnPoint
from scenic_lite.inverse.inversion import propagate
from scenic_lite.inverse.knowledge import Knowledge
from scenic_lite.inverse.solver import solve
from scenic_lite.inverse.wishes import CLOSE, Wish
from scenic_lite.scene.bounds import bounds_of
from scenic_lite.values.geometry import TURN
from scenic_lite.values.graph import RandomExpr, Tape, ThetaColumn, Value, columns_of

if TYPE_CHECKING:
    from scenic_lite.inverse.refusals import Refusals

ROUNDING = 1e-9  # of θ, beyond its ends


class Inverse:
    """Finds θ for a program: the tape of all that can be asked, and how to go back through it."""

    def __init__(self, nodes: Iterable[Value], columns: Sequence[ThetaColumn], points: Sequence[DrawnPoint]) -> None:
        self.columns = list(columns)
        roots = [*(node for node in nodes if isinstance(node, RandomExpr)), *(column.shown for column in columns)]
        roots += [part for each in points for part in (each.point.x, each.point.y) if isinstance(part, RandomExpr)]
        roots = [root for root in roots if self._ours(root)]
        self.tape = Tape(roots, self.columns, 10**9)
        slots = self.tape.slots
        self.points = [each for each in points if all(id(part) in slots for part in (each.point.x, each.point.y))]
        self.slots = slots | {id(column): i for i, column in enumerate(self.columns)}
        self.bounds = bounds_of(self.tape, self.columns)
        self.offset = np.array([column.offset for column in columns])
        self.span = np.array([column.span for column in columns])

    def _ours(self, root: RandomExpr) -> bool:
        """Whether all that a node is computed from has a column of θ."""
        ours = {id(column) for column in self.columns}
        return all(id(column) in ours for column in columns_of(root))

    def theta(self, wishes: list[Wish], default: np.ndarray | None, refusals: Refusals) -> np.ndarray:
        """The rows of θ [N, D] that give what is asked; `default` [D] or [N, D] decides the draws that do not matter.

        Raises ScenicError, made by `refusals`, for draws that nothing decides, and for what cannot be met.
        """
        count = refusals.count_of(wishes)
        if default is not None and len(default) not in (1, count):
            raise ValueError(f"default must be one row of theta or {count} of them, not {len(default)}")
        wishes = [wish._replace(values=np.broadcast_to(wish.values, (count,))) for wish in wishes]
        knowledge = self._known(wishes, count)
        decided = self._decided(wishes)
        if default is None:
            free = [d for d in range(len(self.columns)) if not decided[d] and not knowledge.known[d].all()]
            if free:
                raise refusals.undetermined(free)
        wanted = self._wanted(knowledge, count)  # [N, D], nan where unknown
        base = np.zeros((count, len(self.columns))) if default is None else np.broadcast_to(default, wanted.shape)
        theta = np.where(np.isnan(wanted), base, np.clip(wanted, -1.0, 1.0))
        missed = self.missed(wishes, theta)
        if missed.any():
            theta = self._searched(wishes, theta, np.isnan(wanted), missed)
            missed = self.missed(wishes, theta)
        if missed.any():
            row = int(np.flatnonzero(missed.any(axis=1))[0])
            raise refusals.unmet(wishes, missed, row, wanted[row], self.reached(wishes, theta[row]))
        return theta

    def _known(self, wishes: list[Wish], count: int) -> Knowledge:
        knowledge = Knowledge(self.tape, count, self.bounds)
        for wish in wishes:
            if isinstance(wish.node, RandomExpr):
                slot, rows = self.slots[id(wish.node)], asked(wish.values)
                rows = rows & ~knowledge.known[slot]
                if rows.any():
                    knowledge.learn(slot, rows, wish.values[rows])
        for d in np.flatnonzero(self.span == 0).tolist():
            knowledge.learn(d, ~knowledge.known[d], self.offset[d])
        propagate(knowledge, self.points, self.slots)
        for d, column in enumerate(self.columns):
            if is_noise(column) and not knowledge.known[d].all():  # something else can be the cause: then let it be
                knowledge.learn(d, ~knowledge.known[d], self.offset[d] + 0.5 * self.span[d])
                propagate(knowledge, self.points, self.slots)
        return knowledge

    def _decided(self, wishes: list[Wish]) -> np.ndarray:
        """[D]: which columns have a part in something that is asked."""
        feeding = {id(column) for column in columns_of(*(wish.node for wish in wishes))}
        return np.array([id(column) in feeding for column in self.columns], dtype=bool)

    def _wanted(self, knowledge: Knowledge, count: int) -> np.ndarray:
        """[N, D]: θ as it follows from what is known, perhaps beyond its ends; nan where nothing follows."""
        wanted = np.full((count, len(self.columns)), np.nan)
        for d, (offset, span) in enumerate(zip(self.offset, self.span, strict=True)):
            rows = knowledge.known[d]
            if rows.any():
                unit = (np.asarray(knowledge.values[d], dtype=float)[rows] - offset) / span if span else 0.5
                wanted[rows, d] = 2.0 * unit - 1.0
        return wanted

    # ------------------------------------------------------------ what comes out

    def scaled(self, theta: np.ndarray) -> np.ndarray:
        """Columns [D, N], as the tape wants them."""
        return (self.offset + (theta + 1.0) * 0.5 * self.span).T

    def run(self, theta: np.ndarray, steps: list[Any]) -> list[Any]:
        """The registers that some steps of the tape fill."""
        registers = self.tape.registers.copy()
        registers[: self.tape.dim] = self.scaled(theta)
        with np.errstate(all="ignore"):
            for operation, inputs, out in steps:
                registers[out] = operation(*[registers[i] for i in inputs])
        return registers

    def steps_for(self, wishes: list[Wish]) -> list[Any]:
        """The steps of the tape that compute what is asked."""
        needed = {self.slots[id(wish.node)] for wish in wishes if isinstance(wish.node, RandomExpr)}
        steps = []
        for step in reversed(self.tape.steps):
            if step[2] in needed:
                needed.update(step[1])
                steps.append(step)
        return steps[::-1]

    def residuals(self, wishes: list[Wish], registers: list[Any], rows: Any = slice(None)) -> np.ndarray:
        """[N, W]: by how much each wish is missed, as a share of its size if that is above 1."""
        count = len(registers[0]) if self.columns else len(wishes[0].values[rows])
        parts = [difference(self._value(wish, registers), wish.values[rows], wish.part) for wish in wishes]
        return np.stack([np.broadcast_to(part, count) for part in parts], axis=1)

    def missed(self, wishes: list[Wish], theta: np.ndarray) -> np.ndarray:
        """[N, W]: which wishes are not met."""
        if not wishes or not len(theta):
            return np.zeros((len(theta), len(wishes)), dtype=bool)
        return ~(np.abs(self.residuals(wishes, self.run(theta, self.steps_for(wishes)))) <= CLOSE)

    def reached(self, wishes: list[Wish], theta: np.ndarray) -> list[Any]:
        """The values that one row [D] gives instead."""
        registers = self.run(theta[None], self.tape.steps)
        return [np.broadcast_to(self._value(wish, registers), 1)[0] for wish in wishes]

    def _value(self, wish: Wish, registers: list[Any]) -> Any:
        return registers[self.slots[id(wish.node)]] if isinstance(wish.node, RandomExpr) else wish.node

    # ------------------------------------------------------------ what several equations decide together

    def _searched(self, wishes: list[Wish], theta: np.ndarray, unknown: np.ndarray, missed: np.ndarray) -> np.ndarray:
        """θ with the columns changed that may meet what is missed: first those of which nothing is known, then all."""
        for every in (False, True):
            for group in self._groups(wishes, missed, unknown | every):
                rows = np.flatnonzero(missed.any(axis=1))
                about = [wish for wish in wishes if self._feeds(wish) & set(group)]
                found, good = self._solved(about, theta, rows, group)
                theta[rows[good][:, None], group] = found[good]
            missed = self.missed(wishes, theta)
            if not missed.any():
                break
        return theta

    def _solved(
        self, wishes: list[Wish], theta: np.ndarray, rows: np.ndarray, group: list[int]
    ) -> tuple[np.ndarray, np.ndarray]:
        steps = self.steps_for(wishes)

        def residuals(unit: np.ndarray, index: np.ndarray) -> np.ndarray:
            trial = theta[rows[index]]
            trial[:, group] = 2.0 * unit - 1.0
            return self.residuals(wishes, self.run(trial, steps), rows[index])

        unit, good = solve(residuals, (theta[rows[:, None], group] + 1.0) / 2.0, CLOSE / 10)
        return 2.0 * unit - 1.0, good

    def _feeds(self, wish: Wish) -> set[int]:
        return {self.slots[id(column)] for column in columns_of(wish.node)}

    def _groups(self, wishes: list[Wish], missed: np.ndarray, free: np.ndarray) -> list[list[int]]:
        """The free columns behind what is missed, together where a missed wish depends on several."""
        groups: list[set[int]] = []
        for w in np.flatnonzero(missed.any(axis=0)):
            group = {d for d in self._feeds(wishes[w]) if free[missed[:, w], d].any()}
            touching = [each for each in groups if each & group]
            groups = [each for each in groups if not each & group]
            if group:
                groups.append(group.union(*touching))
        return [sorted(group) for group in groups]


def is_noise(column: ThetaColumn) -> bool:
    """Whether it is a part of what `mutate` adds."""
    return column.owner is not None and column.owner[1].startswith("noise.")


def asked(values: np.ndarray) -> np.ndarray:
    """[N]: in which rows anything is asked."""
    return ~np.isnan(values) if values.dtype.kind == "f" else np.ones(len(values), dtype=bool)


def difference(value: Any, wanted: np.ndarray, part: str) -> np.ndarray:
    """By how much values [N] miss what is wanted; 1 where they are no numbers and not the same."""
    value = np.asarray(value)
    if value.dtype.kind in "biuf" and wanted.dtype.kind in "biuf":
        gap = value.astype(float) - wanted
        if part == "heading":
            gap = gap - TURN * np.rint(gap / TURN)
        gap = gap / np.maximum(1.0, np.abs(wanted))
        return np.where(np.isnan(wanted), 0.0, gap) if wanted.dtype.kind == "f" else gap
    return np.where(np.asarray(value == wanted, dtype=bool), 0.0, 1.0)
