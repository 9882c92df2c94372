"""Kill commands, or interrupt them with Ctrl-C, at any moment of their work; then repeat the same command.

The commands cover each method, with one thread and with two, from the first millisecond on. Read next: `faults`, what
it must come to afterwards.
"""

from __future__ import annotations

import random
import signal
import sys
from pathlib import Path

from lab.torture.faults import SCENARIOS, attacked

SHORTEST = 0.001  # s


def attack(count: int, seed: int, folder: Path, number: int) -> dict[str, int]:
    """Send a signal to `count` commands, cycling through the scenarios; return the count of each outcome."""
    counts: dict[str, int] = {}
    for index in range(count * seed, count * (seed + 1)):
        name = list(SCENARIOS)[index % len(SCENARIOS)]
        outcome = attempt(name, folder, number, random.Random(f"{number} {index}"))
        counts[outcome] = counts.get(outcome, 0) + 1
    return counts


def attempt(name: str, folder: Path, number: int, rng: random.Random) -> str:
    """Send a command a signal at a random moment of its usual time; return the outcome.

    A kill hits the command alone, or all of its processes. Raises AssertionError for any harm.
    """
    target = attacked(name, folder)
    seconds, everybody = rng.uniform(SHORTEST, target.seconds), number == signal.SIGKILL and rng.random() < 0.5
    outcome, end = target.attempt(seconds=seconds, number=number, all=everybody)
    target.seconds = 0.8 * target.seconds + 0.2 * max(end.seconds, target.seconds if end.code else 0.0)
    if number == signal.SIGINT:
        assert end.said.count("regista: interrupted") <= 1, end.said
    return "too late" if end.code == 0 else outcome


def kill(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Kill `count` commands."""
    return attack(count, seed, folder, signal.SIGKILL)


def interrupt(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Interrupt `count` commands."""
    return attack(count, seed, folder, signal.SIGINT)


if __name__ == "__main__":
    print({"kill": kill, "interrupt": interrupt}[sys.argv[1]](int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4])))
