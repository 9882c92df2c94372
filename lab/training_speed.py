"""How many environment steps does training make per second of one core, and where does the time go?

    python -m lab.training_speed --csv lab/results/training_speed.csv
    python -m lab.training_speed --against ../other-checkout       # both, in turns
    python -m lab.training_speed --preset thesis --pixels sparse dense --game 1v1Free --methods dr --shapes 16x128

Every measurement is a separate process: after a few updates, a method trains for some seconds of processor time. Rounds
repeat all measurements, and the table has their medians; the speeds of one round are measured close in time. The
physical limit is the time of the floating point operations of training, at the speed of a large matrix product on this
core; they comprise forward passes and learning. Networks on coordinates of pixels may be faster than this limit, which
counts the products of whole images.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
SHARES = ("sim", "forward", "levels", "learn", "curriculum")
COLUMNS = (
    *("round", "code", "pixels", "game", "method", "num_envs", "num_steps", "steps_per_second"),
    *(*SHARES, "limit", "simulator"),
)  # fmt: skip
BACKWARD = 2  # the gradient of a product needs two products

# Runs in one process; it must also work with the code of older checkouts.
MEASURED = """
import json, sys, time
from dataclasses import replace

time.perf_counter = time.process_time  # of the shares, too
import torch

from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import build

game, method, num_envs, num_steps, seconds, warm, preset, pixels = json.loads(sys.argv[1])
torch.set_num_threads(1)
found = build.find_game(game)
config = found.start(preset)
if pixels != "default":
    config = replace(config, env=replace(config.env, pixels=pixels))
ppo = replace(config.ppo, num_steps=num_steps)
config = replace(config, method=method, minigame=game, num_envs=num_envs, ppo=ppo, seed=1)
made = build.make_method(config, build.make_upomdp(found.task(config).make, num_envs, 1))
for _ in range(warm):
    made.update()
steps, began, spent = made.env_steps, time.process_time(), {}
while time.process_time() - began < seconds:
    for name, value in made.update().items():
        if name.startswith("time/"):
            spent[name[5:]] = spent.get(name[5:], 0.0) + value
steps, took = made.env_steps - steps, time.process_time() - began
products = [weight.numel() for weight in made.student.parameters() if weight.ndim == 2]
for layer in made.student.modules():
    if isinstance(layer, torch.nn.Conv2d):
        layer.register_forward_hook(lambda conv, _, out: products.append(conv.weight.numel() * out[0, 0].numel()))
if len(products) < sum(weight.ndim > 1 for weight in made.student.parameters()):
    space = getattr(made.upomdp.agent_observation_space, "image", made.upomdp.agent_observation_space)
    made.student.value(torch.zeros(1, *space.shape))
print(json.dumps({"steps_per_second": steps / took, "products": sum(products), "epochs": ppo.update_epochs}
      | {"simulator": SIMULATOR_VERSION}
      | {name: value / steps * 1e6 for name, value in spent.items()}))
"""
PEAK = """
import time
import torch
torch.set_num_threads(1)
a, b, c = (torch.randn(1024, 1024) for _ in range(3))
best = 0.0
for _ in range(20):
    began = time.process_time()
    torch.mm(a, b, out=c)
    best = max(best, 2 * 1024**3 / (time.process_time() - began))
print(best)
"""


def main(argv: Sequence[str] | None = None) -> None:
    """Measure, print the table, and write the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--game", default="1v1Rare")
    parser.add_argument("--methods", nargs="+", default=["dr", "paired", "plr"])
    parser.add_argument("--shapes", nargs="+", default=["16x512", "128x64"], help="environments x steps of a rollout")
    parser.add_argument("--preset", choices=["fast", "thesis"], default="fast")
    parser.add_argument("--pixels", nargs="+", choices=["default", "sparse", "dense"], default=["default"])
    parser.add_argument("--against", type=Path, help="another checkout, measured in turns with this one")
    parser.add_argument("--seconds", type=float, default=5.0, help="processor time of each measurement")
    parser.add_argument("--warm", type=int, default=4, help="updates before it")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--csv", type=Path)
    options = parser.parse_args(argv)
    codes = {"this": ROOT} | ({"against": options.against} if options.against else {})
    peak = float(run_python(PEAK, ROOT))
    rows = [
        {"round": number, "code": code, **measure(folder, options, (method, shape, pixels), peak)}
        for number in range(options.rounds)
        for method in options.methods
        for shape in options.shapes
        for pixels in options.pixels
        for code, folder in codes.items()
    ]
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
    print(f"largest matrix product: {peak / 1e9:.0f} GFLOP/s\n\n{table(rows)}")


def measure(folder: Path, options: argparse.Namespace, what: tuple[str, str, str], peak: float) -> dict[str, Any]:
    """Return a row: steps per second, microseconds per step of each activity, and the physical limit.

    `what` is the method, the shape of rollouts, and the form of images.
    """
    method, shape, pixels = what
    num_envs, num_steps = map(int, shape.split("x"))
    settings = [options.game, method, num_envs, num_steps, options.seconds, options.warm, options.preset, pixels]
    found = json.loads(run_python(MEASURED, folder, json.dumps(settings)))
    flops = 2 * found["products"] * (1 + found["epochs"] * (1 + BACKWARD))
    row = {"pixels": pixels, "game": options.game, "method": method, "num_envs": num_envs, "num_steps": num_steps}
    row |= {name: f"{found[name]:.2f}" for name in SHARES} | {"simulator": found["simulator"]}
    return row | {"steps_per_second": round(found["steps_per_second"]), "limit": f"{flops / peak * 1e6:.2f}"}


def run_python(code: str, folder: Path, *arguments: str) -> str:
    """Run code with the modules of a checkout; return the last line of its output."""
    environment = os.environ | {"PYTHONPATH": str(folder.resolve()), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-W", "ignore", "-c", code, *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    return done.stdout.strip().splitlines()[-1]


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return medians over the rounds as a Markdown table, with the ratio to the other code or to dense images."""
    lines = [
        "| method | envs x steps | pixels | code | env steps/s | ratio | us per step: "
        + " | ".join(SHARES)
        + " | limit |",
        "|---" * (7 + len(SHARES)) + "|",
    ]
    groups: dict[tuple[str, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        shape = f"{row['num_envs']} x {row['num_steps']}"
        groups.setdefault((row["method"], shape, row["pixels"], row["code"]), []).append(row)
    speeds = {key: statistics.median(float(row["steps_per_second"]) for row in group) for key, group in groups.items()}
    for key, group in groups.items():
        method, shape, pixels, code = key
        images = None if pixels == "dense" else speeds.get((method, shape, "dense", "this"))
        other = speeds.get((method, shape, pixels, "against"), images)
        ratio = f"{speeds[key] / other:.2f}" if other and code == "this" else ""
        medians = [f"{statistics.median(float(row[name]) for row in group):.2f}" for name in (*SHARES, "limit")]
        lines.append(f"| {' | '.join(key)} | {speeds[key]:,.0f} | {ratio} | {' | '.join(medians)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
