"""Report for each stored profile whether our simulator is most like GRF at the shipped numbers.

    python -m lab.calibration.summary

A number is best if the loss is least at the shipped value, and near if the excess over the least loss may be due to
luck. It is elsewhere if another value is better by more; these numbers are listed. It is undetermined if all values of
the profile are near. The limit for luck is the larger of a twentieth and twice the standard deviation of `luck.py`.
Profiles are those that `profile.py --csv data/profiles/GROUP.csv` writes. Read next: `profile.py`.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

from lab.calibration.luck import LUCK
from lab.calibration.profile import FACTORS, NEAR, best_of

PROFILES = Path(__file__).parent / "data" / "profiles"
VERDICTS = ("best", "near", "elsewhere", "undetermined")


def verdict(losses: list[float], near: float) -> str:
    """Return the verdict on the shipped value, factor 1, from the losses at `FACTORS`; `near` is the limit for luck."""
    best, low, high = best_of(FACTORS, losses, near)
    if (low, high) == (FACTORS[0], FACTORS[-1]):
        return "undetermined"
    if best == 1.0:
        return "best"
    return "near" if losses[FACTORS.index(1.0)] <= min(losses) * (1.0 + near) else "elsewhere"


def losses_of(row: Mapping[str, str]) -> list[float]:
    """Return the losses of a row of a profile, at `FACTORS`."""
    return [float(row[f"{factor:g}"]) for factor in FACTORS]


def lines(path: Path) -> list[str]:
    """Return a summary of one profile: the count of each verdict, and the better values elsewhere."""
    rows = list(csv.DictReader(path.read_text().splitlines()))
    near = max(NEAR, 2.0 * LUCK[rows[0]["family"]][1])
    verdicts = [verdict(losses_of(row), near) for row in rows]
    counts = ", ".join(f"{verdicts.count(each)} {each}" for each in VERDICTS)
    told = [f"{path.stem} ({rows[0]['family']}): {len(rows)} numbers, {counts}"]
    for row, each in zip(rows, verdicts, strict=True):
        if each == "elsewhere":
            losses = losses_of(row)
            best = best_of(FACTORS, losses)[0]
            change = f"loss {losses[FACTORS.index(1.0)]:.3f} to {min(losses):.3f}"
            shipped = float(row["shipped"])
            told.append(f"  {row['number']}: shipped {shipped:g}, best {best * shipped:.3g}, {change}")
    return told


if __name__ == "__main__":
    for each in sorted(PROFILES.glob("*.csv")):
        print(*lines(each), sep="\n")
