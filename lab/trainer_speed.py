"""How many environment steps per second of one core do Regista's DR and PPO of other libraries train on one game?

    python -m lab.trainer_speed --csv lab/results/trainer_speed.csv

Every measurement is a separate process on one thread, see `lab.trainers`: after a warm-up, a trainer trains for some
seconds of processor time. Rounds repeat all measurements, one trainer after the other, and the table has medians. The
table reports libraries that are missing; they are optional:

    pip install stable-baselines3 tensorboard
    pip install --no-deps --ignore-requires-python cleanrl==1.2.0    # its ppo.py runs on newer versions of Python, too

All take 24 gradient steps per rollout, 3 epochs of 8 minibatches, and normalize advantages per minibatch. They differ
in these points:

    regista     normalizes observations by running statistics; plays rollouts and evaluates the policy in a kernel
    sb3         weights the value loss twice as much as regista, which halves the squared error
    cleanrl     learns from truncated episodes as if they were terminated; logs episodes for TensorBoard
    pufferlib   draws segments of one environment with replacement, by the size of their advantages, instead of epochs;
                computes all advantages for each minibatch; clips rewards and values; disregards truncation

PufferLib 3.0.0 has to be built from its source package, with NO_OCEAN=1 and `--no-deps --no-build-isolation`. Its
setup.py needs one more line, `c_extension_paths = []`, which that variable leaves undefined. Its trainer imports
gym==0.23.0, pyro-ppl and rich_argparse.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lab.trainers import missing
from regista.envs.football.version import SIMULATOR_VERSION

ROOT = Path(__file__).parents[1]
TORSOS = {
    "regista": ("shared", "separate"),
    "sb3": ("shared", "separate"),
    "cleanrl": ("separate",),  # the script supports no other torsos
    "pufferlib": ("shared", "separate"),
}
MEASURED = "steps_per_second", "gradient_steps", "weights", "load", "versions"
COLUMNS = "round", "trainer", "torso", "num_envs", "num_steps", *MEASURED, "simulator"


def main(argv: Sequence[str] | None = None) -> None:
    """Measure, write the rows, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--game", default="1v1Rare")
    parser.add_argument("--trainers", nargs="+", default=list(TORSOS), choices=TORSOS)
    parser.add_argument("--shapes", nargs="+", default=["16x512", "128x64"], help="environments x steps of a rollout")
    parser.add_argument("--seconds", type=float, default=10.0, help="processor time of each measurement")
    parser.add_argument("--warm", type=int, default=10, help="updates before it")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--csv", type=Path)
    options = parser.parse_args(argv)
    absent = {trainer: packages for trainer in options.trainers if (packages := missing(trainer))}
    rows = [
        {"round": number, **measure(options, trainer, torso, shape)}
        for number in range(options.rounds)
        for shape in options.shapes
        for trainer in options.trainers
        if trainer not in absent
        for torso in TORSOS[trainer]
    ]
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
    print(table(rows, absent))


def measure(options: argparse.Namespace, trainer: str, torso: str, shape: str) -> dict[str, Any]:
    """Return a row without its round; `load` has the load averages of 1, 5 and 15 minutes after the measurement."""
    num_envs, num_steps = map(int, shape.split("x"))
    row = {"trainer": trainer, "torso": torso, "num_envs": num_envs, "num_steps": num_steps}
    found = run(row | {"game": options.game, "warm": options.warm, "seconds": options.seconds})
    row |= {
        "simulator": SIMULATOR_VERSION,
        "steps_per_second": round(found.pop("speed")),
        "load": " ".join(f"{load:.2f}" for load in os.getloadavg()),
    }
    return row | found | {"gradient_steps": round(found["gradient_steps"], 3)}


def run(request: Mapping[str, Any]) -> dict[str, Any]:
    """Measure with `lab.trainers` in a new process. Raises RuntimeError with its error output if it fails."""
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-W", "ignore", "-m", "lab.trainers", json.dumps(request)]
    with tempfile.TemporaryDirectory() as folder:  # for the files of trainers
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"the measurement {json.dumps(request)} failed:\n{done.stderr}")
    return json.loads(done.stdout.strip().splitlines()[-1])


def table(rows: Sequence[Mapping[str, Any]], absent: Mapping[str, Sequence[str]]) -> str:
    """Return medians over the rounds as a Markdown table; Regista's speed is divided by that of each trainer."""
    lines = [
        "| trainer | torsos | weights | envs x steps | gradient steps | env steps/s | smallest, largest | Regista is |",
        "|---|---|---|---|---|---|---|---|",
    ]
    groups: dict[tuple[str, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        shape = f"{row['num_envs']} x {row['num_steps']}"
        groups.setdefault((row["trainer"], row["torso"], shape), []).append(row)
    speeds = {key: statistics.median(row["steps_per_second"] for row in group) for key, group in groups.items()}
    for key, group in groups.items():
        trainer, torso, shape = key
        found, ours = [row["steps_per_second"] for row in group], speeds.get(("regista", torso, shape))
        ratio = f"{ours / speeds[key]:.1f} times as fast" if ours and trainer != "regista" else ""
        counts = f"{group[0]['weights']:,} | {shape} | {group[0]['gradient_steps']:.0f}"
        extremes = f"{min(found):,}, {max(found):,}"
        lines.append(f"| {trainer} | {torso} | {counts} | {speeds[key]:,.0f} | {extremes} | {ratio} |")
    for trainer, packages in absent.items():
        lines.append(f"| {trainer} | {', '.join(packages)} not installed | | | | | | |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
