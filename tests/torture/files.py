"""Run folders in which a file is damaged: the run goes on, or one sentence says why not, and nothing is overwritten."""

from __future__ import annotations

import io
import shutil
import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import torch

from experiments.__main__ import main
from experiments.commands.train import restore
from experiments.run import build
from experiments.run.errors import CommandError
from experiments.run.folder import RunFolder
from experiments.run.table import read_columns
from tests.envs.hostile import damaged
from ued.checkpoint import CheckpointError

FILES = ("checkpoint.pt", "checkpoint.pt", "config.json", "metrics.csv", "levels.csv", "program.scenic")
SECONDS = 2.0  # of processor time, at most, for one attempt
STRANGE: list[Any] = [None, -1, 10**9, 10**30, float("nan"), float("inf"), "", "x" * 100, [], {}, [[[]]], True, 0.5]
SETTINGS = ["--num-envs", "4", "--num-steps", "32", "--no-record", "--eval-every", "0"]
WENT_ON, REFUSED = "went on", "refused in a sentence"


def make_run(folder: Path, steps: int = 1_000) -> Path:
    """Train a small run."""
    path = folder / "run"
    words = ["train", "1v1Restricted", "--method", "plr", "--total-env-steps", str(steps), *SETTINGS]
    if not path.exists():
        assert quietly([*words, "--out", str(path)])[0] == 0
    return path


def quietly(words: list[str]) -> tuple[int, str]:
    """Run a command in this process; return its exit code and what it wrote on stderr."""
    said = io.StringIO()
    with redirect_stdout(io.StringIO()), redirect_stderr(said):
        return main(words), said.getvalue()


class Target:
    """A run, and a method of its kind that can take its checkpoint again and again."""

    def __init__(self, folder: Path) -> None:
        self.run, self.folder = make_run(folder), folder
        config = RunFolder.open(self.run).config
        program = build.load_scenes(config)[build.TRAINING_SCENE]
        self.upomdp = build.make_upomdp(program, config.num_envs, config.env, config.seed, 1)
        self.method = build.make_method(config, self.upomdp)
        self.content = torch.load(self.run / "checkpoint.pt", weights_only=True)

    def attempt(self, rng: np.random.Generator) -> str:
        """Damage one file of a copy and go on from it. Raises AssertionError for any harm."""
        name, path = str(rng.choice(FILES)), self.folder / "copy"
        shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(self.run, path)
        file = path / name
        if name == "checkpoint.pt" and rng.random() < 0.7:
            self.save_altered(file, rng)
        else:
            file.write_bytes(damaged(file.read_bytes(), rng))
        before, began = contents(path), time.process_time()
        try:
            run = RunFolder.open(path)
            read_columns(run.metrics.path), read_columns(run.levels.path)
            restore(run, self.method)
            outcome = WENT_ON
        except (CommandError, CheckpointError, OSError) as error:
            assert "\n" not in str(error).strip() and len(str(error)) < 2_000, error
            assert contents(path) == before, f"{name} was refused, and something was overwritten"
            outcome = REFUSED
        assert time.process_time() - began < SECONDS, f"{name} took too long"
        return outcome

    def save_altered(self, file: Path, rng: np.random.Generator) -> None:
        """Write a whole checkpoint of which one entry, however deep, is another one."""
        content = torch.load(self.run / "checkpoint.pt", weights_only=True)
        holder: Any = content
        while True:
            keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
            key = keys[rng.integers(len(keys))]
            inside = holder[key]
            if not isinstance(inside, dict | list) or not inside or rng.random() < 0.08:
                break
            holder = inside
        kind = rng.integers(4)
        if isinstance(inside, torch.Tensor) and kind < 3:
            changed = inside.clone()
            if changed.numel() and kind == 0:
                changed.view(-1)[int(rng.integers(changed.numel()))] = int(rng.integers(0, 255))
            elif changed.is_floating_point() and kind == 1:
                changed.view(-1)[:1] = float("nan")
            else:
                changed = changed[: len(changed) // 2] if changed.ndim else changed
            holder[key] = changed
        elif isinstance(holder, dict) and kind == 3:
            del holder[key]
        else:
            holder[key] = STRANGE[rng.integers(len(STRANGE))]
        torch.save(content, file)


def contents(folder: Path) -> dict[str, bytes]:
    return {each.name: each.read_bytes() for each in folder.iterdir() if each.is_file()}


def attack(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Damage so many run folders; return how many went on and how many were refused."""
    rng, target, counts = np.random.default_rng(seed), Target(folder), {WENT_ON: 0, REFUSED: 0}
    for _ in range(count):
        counts[target.attempt(rng)] += 1
    return counts


if __name__ == "__main__":
    print(attack(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])))
