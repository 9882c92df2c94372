"""Static programs: sample scenes and describe the distribution of every number and word in them.

Fields as the oracle has them: `values`, a description for each column `o<i>.x`, `o<i>.y`, `o<i>.heading`,
`o<i>.<property>`, `param.<name>` (vectors as `name[0]`, `name[1]`); `corr`, `rel`, `acceptance`. Read next: `compare`.
"""

import collections
import math
from pathlib import Path

import numpy as np

from scenic_lite import Domain, Program, Scenes, load

CANDIDATES = 20_000  # draws by which the acceptance is measured
QUANTILES = 41
MOST_COUNTED = 25  # values of a number that are counted one by one
MOST_CORRELATED = 30


def static(path: Path, entries: dict[str, str], world: Domain, dialect: int) -> dict:
    """Return the record's fields for a program of kind `static`. Raises ScenicError if it is none."""
    program, count = load(path, world, dialect), int(entries["n"])
    rng = np.random.default_rng(7)
    _, scenes = program.sample(count, rng)
    columns = columns_of(program, scenes, [name for name in entries.get("props", "").split(",") if name])
    return described(columns, [each.class_name for each in program.objects]) | {
        "n": count,
        "acceptance": rounded(acceptance(program, count, rng)),
    }


def described(columns: dict[str, list], objects: list[str]) -> dict:
    """Return the statistics of columns of equal length."""
    fields: dict = {"objects": objects, "values": {name: describe(name, column) for name, column in columns.items()}}
    varying = [name for name, value in fields["values"].items() if "sd" in value][:MOST_CORRELATED]
    if len(varying) > 1:
        matrix = np.corrcoef(np.array([columns[name] for name in varying]))
        fields["corr"] = {"names": varying, "matrix": np.round(matrix, 3).tolist()}
    fields["rel"] = {
        f"o{i}.{axis}-o0.{axis}": offset(columns[f"o0.{axis}"], columns[f"o{i}.{axis}"])
        for i in range(1, len(objects))
        for axis in "xy"
    }
    return fields


def offset(first: list[float], other: list[float]) -> dict:
    """Return how far an object is from the first one along an axis."""
    description = describe("", [b - a for a, b in zip(first, other, strict=True)])
    return {key: value for key, value in description.items() if key not in ("quantiles", "counts")}


# ---------------------------------------------------------------- columns


def columns_of(program: Program, scenes: Scenes, properties: list[str]) -> dict[str, list]:
    """Return plain values over the scenes, by the oracle's names."""
    count, columns = len(scenes.ok), {}
    for i in range(len(program.objects)):
        columns[f"o{i}.x"] = scenes.positions[:, i, 0].tolist()
        columns[f"o{i}.y"] = scenes.positions[:, i, 1].tolist()
        columns[f"o{i}.heading"] = scenes.headings[:, i].tolist()
        for name in properties:
            value = {"position": scenes.positions[:, i], "heading": scenes.headings[:, i]}.get(name)
            value = scenes.properties.get(name, [None] * (i + 1))[i] if value is None else value
            columns |= flat(f"o{i}.{name}", rows_of(value, count))
    for name, value in scenes.params.items():
        columns |= flat(f"param.{name}", rows_of(value, count))
    return columns


def rows_of(value: object, count: int) -> list:
    """Return a value of Scenes, scene by scene, in plain Python; a vector is a pair."""
    if isinstance(value, np.ndarray):
        return [tuple(row) if isinstance(row, list) else row for row in value.tolist()]
    if isinstance(value, tuple):
        parts = [rows_of(part, count) for part in value]
        return list(zip(*parts, strict=True)) if parts else [()] * count
    return [value] * count


def flat(name: str, rows: list) -> dict[str, list]:
    """Return one column, or two of a vector; none for what has no place in the oracle's files, such as lists."""
    if all(isinstance(row, tuple) and row and all(is_number(part) for part in row) for row in rows):
        width = min(2, *map(len, rows))
        return {f"{name}[{i}]": [float(row[i]) for row in rows] for i in range(width)}
    if all(is_number(row) or isinstance(row, bool | str | None) for row in rows):
        return {name: [float(row) if is_number(row) else row for row in rows]}
    return {}


def is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


# ---------------------------------------------------------------- statistics


def rounded(value: float) -> float:
    """Return seven digits, and no negative zero."""
    return float(f"{value:.7g}") + 0.0


def describe(name: str, column: list) -> dict:
    """`{"const": v}`, or the distribution: of numbers by moments and quantiles, of words by counts."""
    if not all(isinstance(value, float) for value in column):
        counts = collections.Counter(map(repr, column))
        return {"const": column[0]} if len(counts) == 1 else {"counts": dict(counts.most_common(40))}
    array = np.array(column)
    if array.max() - array.min() <= 1e-9 * max(1, abs(array.max())):
        return {"const": rounded(array[0])}
    description: dict = {"mean": array.mean(), "sd": array.std(ddof=1), "min": array.min(), "max": array.max()}
    if name.endswith("heading"):
        turn = np.exp(1j * array).mean()
        description |= {"circular_mean": math.atan2(turn.imag, turn.real), "resultant": abs(turn)}
    description = {key: rounded(value) for key, value in description.items()}
    description["quantiles"] = [rounded(value) for value in np.quantile(array, np.linspace(0, 1, QUANTILES))]
    if len(set(column)) <= MOST_COUNTED:
        counts = collections.Counter(rounded(value) for value in column)
        description["counts"] = {repr(value): times for value, times in sorted(counts.items())}
    return description


def acceptance(program: Program, count: int, rng: np.random.Generator) -> float:
    """Return scenes per attempt, as Scenic counts them: which soft requirements hold is drawn once for each scene."""
    failed = program.instantiate(rng.uniform(-1, 1, (CANDIDATES if program.dim else 1, program.dim))).failed
    share = np.array([rule.probability for rule in program.requirements])
    masks, times = np.unique(rng.random((count, len(share))) < share, axis=0, return_counts=True)
    accepted = np.array([1 - (failed & mask).any(axis=1).mean() for mask in masks])
    with np.errstate(divide="ignore"):
        return float(count / (times / accepted).sum())
