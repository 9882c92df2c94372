"""Let every change that a command makes on the disk fail once, or be its last; then repeat the same command.

From the remaining files, the repeated command must reach the tables of an undisturbed run, or refuse with a reason in
one sentence. The k-th change of a command meets each of four faults (see `forks.KINDS`), in an order that covers every
k.
"""

from __future__ import annotations

import csv
import shutil
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from math import gcd
from pathlib import Path

import numpy as np

from lab.torture.forks import KINDS, End, Forks, Order
from tests.attacks.files import TASK
from ued.core.files import PARTIAL
from ued.methods import METHODS

PPO = ["--num-steps", "16", "--hidden-size", "8", "--update-epochs", "1", "--num-minibatches", "1"]
TINY = ["--num-envs", "4", *PPO, "--total-env-steps", "256", "--eval-every", "128", "--eval-episodes", "4"]
SAVING = [*TINY, "--checkpoint-seconds", "0"]
QUIET = [*SAVING, "--no-record"]
FOOTBALL = ["1v1Restricted", "--num-envs", "2", *PPO, "--total-env-steps", "64", "--eval-every", "0"]


@dataclass(frozen=True)
class Scenario:
    """A command that writes. `{out}` is its output folder, `{made}` holds its inputs: see `MADE`."""

    words: list[str]
    resumed: list[str] | None = None  # tried first afterwards; then, or without it, the command itself


def train(method: str, *more: str) -> Scenario:
    """Return a training command on the toy task."""
    return Scenario(["train", TASK, "--method", method, *more, "--out", "{out}"], ["train", "--resume", "{out}"])


COMPARE = ["compare", TASK, "--methods", "dr", "plr", "--seeds", "1", *QUIET, "--episodes", "4", "--levels", "0"]
MADE = {
    "run": ["train", TASK, "--method", "dr", *QUIET, "--out", "{made}/run"],
    "demos": ["demonstrate", "1v1Restricted", "--episodes", "2", "--keep", "all", "--out", "{made}/demos"],
    "recorded": ["train", TASK, "--method", "plr", *SAVING, "--out", "{made}/recorded"],
    "match.npz": ["play", "1v1Restricted", "--record", "{made}/match.npz"],
}
WRITERS = {  # writing commands, one of each kind
    "train dr": train("dr", *QUIET),
    "train plr": train("plr", *QUIET),
    "train paired": train("paired", *QUIET),
    "train plr, recorded": train("plr", *SAVING),
    "train football": Scenario(["train", *FOOTBALL, "--out", "{out}"], ["train", "--resume", "{out}"]),
    "train from": train("dr", *QUIET, "--from", "{made}/run", "--kl-to-clone", "0.5"),
    "gallery": Scenario(["evaluate", "--gallery", "{made}/recorded"]),
    "compare": Scenario([*COMPARE, "--processes", "1", "--out", "{out}"]),
    "demonstrate": Scenario(["demonstrate", "1v1Restricted", "--episodes", "2", "--keep", "all", "--out", "{out}"]),
    "clone": Scenario(["clone", "{made}/demos", "--epochs", "2", "--ppo.hidden-size", "8", "--out", "{out}"]),
    "play": Scenario(["play", "1v1Restricted", "--record", "{out}/match.npz"]),
    "evaluate": Scenario(["evaluate", "{made}/run", "--episodes", "4", "--levels", "0", "--csv", "{out}/all.csv"]),
}
SCENARIOS = WRITERS | {
    f"train {method}, {threads} threads": train(method, *QUIET, "--threads", str(threads))
    for method in METHODS
    for threads in (1, 2)
}


class Attacked:
    """A scenario, its tables without faults, and its number of changes."""

    def __init__(self, name: str, forks: Forks, folder: Path) -> None:
        self.name, self.forks, self.folder, self.scenario = name, forks, folder, SCENARIOS[name]
        made = folder / "made"
        made.mkdir(parents=True, exist_ok=True)
        for file, words in MADE.items():
            if any(f"{{made}}/{file}" in word for word in self.scenario.words) and not (made / file).exists():
                self.succeed(words, made)
        self.undisturbed = self.succeed(self.scenario.words, self.empty("undisturbed"))
        self.tables, self.seconds = contents(folder / "undisturbed"), self.undisturbed.seconds

    def empty(self, name: str) -> Path:
        """Return an empty folder."""
        path = self.folder / name
        shutil.rmtree(path, ignore_errors=True)
        path.mkdir(parents=True)
        return path

    def order(self, words: list[str], out: Path, **fate: object) -> Order:
        """Return the order to run a command."""
        words = [word.format(out=out, made=self.folder / "made") for word in words]
        return Order(words, str(out), **fate)  # type: ignore[arg-type]

    def succeed(self, words: list[str], out: Path) -> End:
        """Run a command that must succeed."""
        end = self.forks.run(self.order(words, out))
        assert end.code == 0 and not end.left, f"{self.name}: exit code {end.code}: {end.said}"
        return end

    def attempt(self, **fate: object) -> tuple[str, End]:
        """Run the command with a fault or signal, then repeat it; return the outcome. Raises AssertionError on harm."""
        out = self.empty("attacked")
        end = self.forks.run(self.order(self.scenario.words, out, **fate))
        what = f"{self.name}, {fate}: exit code {end.code}: {end.said[-1000:]}"
        check(end, what)
        if end.code == 0:
            self.compare(out, what)
            return "went on", end
        return self.go_on(out, what), end

    def go_on(self, out: Path, what: str) -> str:
        """Continue from the files that a command has left, first with `--resume`."""
        for words in filter(None, (self.scenario.resumed, self.scenario.words)):
            before = contents(out)
            end = self.forks.run(self.order(words, out))
            check(end, f"{what}; then {' '.join(words[:2])}: exit code {end.code}: {end.said[-1000:]}")
            if end.code == 0:
                self.compare(out, what)
                return "went on after it"
            assert contents(out) == before, f"{what}; then {end.said}, and something was overwritten"
        return "said why not"

    def compare(self, out: Path, what: str) -> None:
        """Raise AssertionError if tables differ from those of an undisturbed command."""
        tables = contents(out)
        differing = [name for name in tables.keys() | self.tables.keys() if tables.get(name) != self.tables.get(name)]
        assert not differing, f"{what}; {', '.join(differing)} came out differently"
        rest = [path.name for path in out.rglob("*") if path.name.endswith((".part", PARTIAL))]
        assert not rest, f"{what}; {', '.join(rest)} were left"


def check(end: End, what: str) -> None:
    """Raise AssertionError unless a command succeeded, ended with a one-sentence error, or by the sent signal."""
    assert not end.left, f"{what}; {end.left} processes were left"
    assert all(word not in end.said for word in ("Traceback", "Exception ignored", "panicked")), what
    assert end.code in (0, 1, 130, -9), what
    assert end.code != 1 or sum(line.startswith("regista: ") for line in end.said.splitlines()) >= 1, what


def contents(folder: Path) -> dict[str, object]:
    """Return the tables, records and pages in a folder, without wall-clock columns.

    Recordings are excluded: episodes that were open at a checkpoint are missing from replays.csv after it.
    """
    files: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix == ".csv" and path.name != "replays.csv":
            files[str(path.relative_to(folder))] = list(rows(path))
        elif path.suffix == ".html":
            files[path.name] = path.read_text()
        elif path.suffix == ".npz":
            with np.load(path) as arrays:  # not the bytes, since padding between the fields of a match is arbitrary
                files[str(path.relative_to(folder))] = {key: repr(arrays[key].tolist()) for key in arrays.files}
    return files


def rows(path: Path) -> Iterator[tuple[tuple[str, str], ...]]:
    """Yield the rows of a table as pairs of name and cell."""
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            yield tuple((name, str(cell)) for name, cell in row.items() if not str(name).startswith("time/"))


@cache
def attacked(name: str, folder: Path) -> Attacked:
    """Return an attacked scenario of this suite, made once."""
    path = folder / name.replace(" ", "_").replace(",", "")
    path.mkdir(parents=True, exist_ok=True)
    return Attacked(name, forks(folder), path)


@cache
def forks(folder: Path) -> Forks:
    """Return the server of this suite, started once."""
    return Forks(folder)


def fault(number: int, changes: Sequence[int]) -> tuple[int, int, str]:
    """Return the index of the attacked command, the number of the change, and the kind of fault for an attempt.

    `changes` has the number of changes of each command. Each change meets each fault once before any repeats, in a
    mixed order.
    """
    ends = np.cumsum(changes)
    faults = len(KINDS) * int(ends[-1])
    stride = next(step for step in range(int(0.618 * faults), 2 * faults + 2) if step and gcd(step, faults) == 1)
    at, kind = divmod(number * stride % faults, len(KINDS))
    which = int(np.searchsorted(ends, at, side="right"))
    return which, at - int(ends[which]) + changes[which], KINDS[kind]


def attack(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Let `count` changes fail; return the count of each outcome."""
    counts: dict[str, int] = {}
    targets = [attacked(name, folder) for name in WRITERS]
    for number in range(count * seed, count * (seed + 1)):
        which, at, kind = fault(number, [target.undisturbed.changes for target in targets])
        outcome, _ = targets[which].attempt(at=at, kind=kind)
        counts[outcome] = counts.get(outcome, 0) + 1
    return counts


if __name__ == "__main__":
    for name in sys.argv[3:] or WRITERS:
        target = attacked(name, Path(sys.argv[2]))
        changes, outcomes = target.undisturbed.changes, dict[str, int]()
        print(f"{name}: {changes} changes, {target.undisturbed.seconds:.1f} s", flush=True)
        for number in range(int(sys.argv[1])):
            _, at, kind = fault(number, [changes])
            try:
                outcome, end = target.attempt(at=at, kind=kind)
                if outcome == "said why not":
                    print(outcome, at, kind, end.said)
            except AssertionError as harm:
                outcome = "HARM"
                print(harm, flush=True)
            outcomes[outcome] = outcomes.get(outcome, 0) + 1
        print(name, outcomes, flush=True)
