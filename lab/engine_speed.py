"""How fast are both engines? Environment steps per second of one processor, in our simulator and in GRF.

Each game is played in both engines, one after the other on one machine. Both use the same random actions, the same
observations (`simple115`), and whole episodes with resets. The measure is processor time, including that of GRF's own
processes, so other programs on the machine hardly matter. The time to start GRF's processes is excluded. GRF needs
`make grf`:

    python -m lab.engine_speed --csv lab/results/engine_speed.csv
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from lab.benchmarks.timing import random_steps
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import build
from regista.experiments.run.config import EngineConfig, TrainConfig
from regista.experiments.run.games import find_minigame
from regista.experiments.run.programs import load_program

GAMES = ("1v1Free", "academy/3_vs_1_with_keeper", "academy/counterattack_easy")
ENVIRONMENTS = {"regista": 256, "grf": 4}
TICK = os.sysconf("SC_CLK_TCK")  # clock ticks of processor time per second


def processor_seconds() -> float:
    """Return the processor time of this process and of its living children."""
    total, me = time.process_time(), os.getpid()
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:  # the process has ended meanwhile
            continue
        if int(fields[1]) == me:
            total += (int(fields[11]) + int(fields[12])) / TICK
    return total


def steps_per_second(game: str, engine: str, seconds: float) -> tuple[float, int]:
    """Return environment steps per processor second, and the number of players."""
    config = EngineConfig(engine=engine).instead_of(TrainConfig(minigame=game).env)
    program = load_program(find_minigame(game).program, None)
    count = ENVIRONMENTS[engine]
    with closing(build.make_matches(program, count, config, 0, 1)) as env:
        step: Callable[[int], None] = random_steps(env)
        step(64)
        began, steps, before = time.monotonic(), 0, processor_seconds()
        while time.monotonic() - began < seconds:
            step(64)
            steps += 64 * count
        return steps / (processor_seconds() - before), env.num_players


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--games", nargs="+", default=GAMES)
    parser.add_argument("--seconds", type=float, default=20.0, help="of each game in each engine, each time")
    parser.add_argument("--times", type=int, default=3, help="measurements of each, one engine after the other")
    parser.add_argument("--csv", type=Path, required=True)
    arguments = parser.parse_args()
    rows = [measure(game, arguments.seconds, arguments.times) for game in arguments.games]
    arguments.csv.parent.mkdir(parents=True, exist_ok=True)
    with open(arguments.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def measure(game: str, seconds: float, times: int) -> dict[str, Any]:
    """Return the row of a game: the median of each engine, and the median, smallest and largest ratio."""
    pairs = np.array([[steps_per_second(game, engine, seconds)[0] for engine in ENVIRONMENTS] for _ in range(times)])
    players = steps_per_second(game, "regista", 0.1)[1]
    ratios = pairs[:, 0] / pairs[:, 1]
    row = {"game": game, "players": players, "simulator": SIMULATOR_VERSION}
    row |= {name: round(float(np.median(pairs[:, k]))) for k, name in enumerate(("ours", "grf"))}
    row |= {"ratio": round(float(np.median(ratios))), "smallest": round(ratios.min()), "largest": round(ratios.max())}
    print(row, flush=True)
    return row


if __name__ == "__main__":
    main()
