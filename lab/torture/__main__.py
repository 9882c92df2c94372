"""The torture suite: minutes or hours of attacks that must do no harm, in rounds, with a report of the attempts.

    python -m lab.torture [--minutes 10] [--report runs/torture.json] [--only states code]
    python -m lab.torture --merge one.json two.json    # add reports of suites that ran beside each other
    python -m lab.torture --page                       # write what the report counts into docs/torture.md

Each part runs rounds of a fixed number of attempts, and every round has its own seed. The part with the least time so
far is next. The report is written after each round, and a stopped suite continues with the following seeds. A new
report starts from `life.json`, the report of the page. With NUMBA_BOUNDSCHECK=1 kernels are compiled with bounds
checks, and counted separately.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

from lab.torture import moments
from lab.torture.faults import attack as inject_faults
from lab.torture.language import attack as attack_language
from lab.torture.matches import attack as play_matches
from lab.torture.options import attack as type_wrongly
from lab.torture.worker import Worker
from tests.attacks.calls import attack as attack_calls
from tests.attacks.files import attack as attack_folders
from tests.attacks.interrupts import attack as interrupt_commands
from tests.envs.hostile import attack_records, attack_states
from tests.scenic_lite.dynamics.hostile import attack as attack_code
from ued.core.files import write_whole

LIFE = Path(__file__).with_name("life.json")  # the report that the page quotes
ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "torture.md"
HEAD = "| what | how many | what became of them | harm, fixed | harm |\n|---|---|---|---|---|\n"
CHECKED = " with bounds checks" if os.environ.get("NUMBA_BOUNDSCHECK") == "1" else ""
# Paths in front of files; they are removed from reports that go into the repository.
FOLDERS = re.compile(rf"{re.escape(str(ROOT))}/|{re.escape(tempfile.gettempdir())}/tmp\w+/")
EMPTY: dict[str, Any] = {"rounds": 0, "seconds": 0.0, "counts": {}, "harm": []}


class Part(NamedTuple):
    """The counted unit, the number per round, and a function that runs a round from it, a seed and a folder."""

    unit: str
    size: int
    attack: Callable[[int, int, Path], dict[str, int]]


PARTS = {
    "states": Part("states with a number changed", 4_800, lambda count, seed, _: attack_states(count, seed)),
    "code": Part("code or registers with a number changed", 5_000, lambda count, seed, _: attack_code(count, seed)),
    "records": Part("records of matches damaged", 1_000, attack_records),
    "folders": Part("run folders damaged", 500, attack_folders),
    "calls": Part("calls of environments made wrongly", 500, lambda count, seed, _: attack_calls(count, seed)),
    "options": Part("command lines typed wrongly", 300, type_wrongly),
    "language": Part("texts of programs", 10_000, lambda count, seed, _: attack_language(count, seed)),
    "faults": Part("changes on the disk that failed, or were the last", 10, inject_faults),
    "kills": Part("commands killed", 10, moments.kill),
    "ctrl-c": Part("commands interrupted in their work", 10, moments.interrupt),
    "interrupts": Part("commands interrupted", 9, interrupt_commands),
    "matches": Part("player-steps", 256, lambda count, seed, _: play_matches(count, seed)),
}


def run_round(name: str, seed: int, folder: Path) -> dict[str, int]:
    """Run one round of a part; return its counts."""
    part = PARTS[name]
    (folder / name).mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return part.attack(part.size, seed, folder / name)


def main(argv: list[str]) -> int:
    """Run rounds until the time is over; return 1 if any harm is reported."""
    parser = argparse.ArgumentParser(prog="python -m lab.torture")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--report", type=Path, default=Path("runs/torture.json"))
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--mended", nargs="+", default=[], metavar="ROW", help="the harm in these rows is mended")
    parser.add_argument("--merge", nargs="+", type=Path, default=[], help="reports begun from the page's: add the rest")
    parser.add_argument("--page", action="store_true", help="write the report's table into docs/torture.md")
    typed = parser.parse_args(argv)
    begun = next((path for path in (typed.report, LIFE) if path.exists()), None)
    report: dict[str, Any] = json.loads(begun.read_text()) if begun else {}
    typed.report.parent.mkdir(parents=True, exist_ok=True)
    for row in (report[name] for name in typed.mended):
        row["mended"], row["harm"] = row.get("mended", 0) + len(row["harm"]), []
    for path in typed.merge:
        merge(report, json.loads(path.read_text()), json.loads(LIFE.read_text()))
    if typed.page:
        quote(report)
    elif not typed.mended and not typed.merge:
        do_rounds(report, typed)
        print(table(report))
    save(report, typed.report)
    return int(any(row["harm"] for row in report.values()))


def do_rounds(report: dict[str, Any], typed: argparse.Namespace) -> None:
    """Run rounds until the time is over, and save the report."""
    end = time.monotonic() + 60 * typed.minutes
    with tempfile.TemporaryDirectory() as folder:
        worker = Worker(lambda name, seed: run_round(name, seed, Path(folder)))
        with closing(worker):
            while time.monotonic() < end:
                done = {name: report.setdefault(name + CHECKED, new_row(name)) for name in typed.only}
                name = min(typed.only, key=lambda each: done[each]["seconds"])
                do_round(worker, name, done[name])
                save(report, typed.report)


def do_round(worker: Worker, name: str, row: dict[str, Any]) -> None:
    """Run the next round of a part, and count it in its row."""
    began, counts = time.monotonic(), {}
    try:
        counts = worker.do(name, row["rounds"])
    except AssertionError as harm:
        row["harm"].append(FOLDERS.sub("", f"round {row['rounds']}: {harm}")[:2_000])
        print(f"{name}, round {row['rounds']}: {harm}", file=sys.stderr, flush=True)
    row["rounds"] += 1
    row["seconds"] += time.monotonic() - began
    for what, count in counts.items():
        row["counts"][what] = row["counts"].get(what, 0) + count


def merge(report: dict[str, Any], other: dict[str, Any], base: dict[str, Any]) -> None:
    """Add the counts of another report since it started from `base`."""
    for name, row in other.items():
        into, before = report.setdefault(name, {**row, **EMPTY, "counts": {}, "harm": []}), base.get(name, EMPTY)
        for key in ("rounds", "seconds"):
            into[key] += row[key] - before[key]
        for what, count in row["counts"].items():
            into["counts"][what] = into["counts"].get(what, 0) + count - before["counts"].get(what, 0)
        into["harm"] = into["harm"] + row["harm"][len(before["harm"]) :]


def save(report: dict[str, Any], path: Path) -> None:
    """Replace the report atomically."""
    write_whole(path, json.dumps(report, indent=2) + "\n")


def new_row(name: str) -> dict[str, Any]:
    return {"unit": PARTS[name].unit + CHECKED, **EMPTY, "counts": {}, "harm": []}


def table(report: dict[str, Any]) -> str:
    """Return the report as a Markdown table."""
    lines = []
    for row in sorted(report.values(), key=lambda each: each["unit"].endswith("bounds checks")):
        total = sum(row["counts"].values())
        parts = ", ".join(f"{count:,} {what}" for what, count in sorted(row["counts"].items()) if count)
        lines.append(f"| {row['unit']} | {total:,} | {parts} | {row.get('mended', 0)} | {len(row['harm'])} |\n")
    return HEAD + "".join(lines)


def quote(report: dict[str, Any]) -> None:
    """Write the table into the page, and store its report."""
    before, _, rest = PAGE.read_text().partition(HEAD.partition(" harm")[0])
    after = re.sub(r"\A.*?\n(?=[^|])", "", rest, count=1, flags=re.DOTALL)
    write_whole(PAGE, f"{before}{table(report)}{after}")
    save(report, LIFE)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
