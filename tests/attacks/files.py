"""Run folders in which a file is damaged: the run goes on, or one sentence says why not, and nothing is overwritten.

Most are read as `train --resume` reads them, in this process; some as `load_policy` does, or by a whole command. Read
next: `lab.torture.__main__`.
"""

from __future__ import annotations

import io
import re
import shutil
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import torch

from regista.experiments.__main__ import main
from regista.experiments.commands.train import restore
from regista.experiments.run import build, origin
from regista.experiments.run.errors import USERS, CommandError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.table import read_columns
from tests.envs.hostile import damaged
from ued.adapters.policy import load_policy
from ued.core.checkpoint import CheckpointError

TASK = f"{Path(__file__).with_name('toy_task.py')}:walk"
FILES = ("checkpoint.pt", "checkpoint.pt", "config.json", "metrics.csv", "levels.csv", "program.scenic")
MORE = ("checkpoint.pt", "checkpoint.pt", "checkpoint.pt", "replays.csv", "origin.pt", "owner.json")
SECONDS, LONGER = 2.0, 30.0  # of processor time, at most, for one attempt; for one with a whole command
STRANGE: list[Any] = [None, -1, 10**9, 10**30, float("nan"), float("inf"), "", "x" * 100, [], {}, [[[]]], True, 0.5]
ONCE = ["--update-epochs", "1", "--num-minibatches", "1"]
SETTINGS = ["--num-envs", "4", "--num-steps", "32", "--no-record", "--eval-every", "0", "--hidden-size", "8", *ONCE]
MISSING = 0.15  # how often another file is not there, or this one
UPDATED = 0.3  # how many of those that can go on are trained for an update
WENT_ON, REFUSED, FAULTED = "went on", "refused in a sentence", "stopped in its first update"
RUNS = {  # of each kind that keeps something else
    "run": ["1v1Restricted", "--method", "plr"],
    "remembering": [TASK, "--method", "paired", "--memory", "gru"],
    "mixed": ["1v1Restricted+1v1Free", "--method", "accel"],
    "recorded": [TASK, "--method", "plr", "--record"],
    "begun": [TASK, "--method", "dr", "--from", "{remembering}", "--kl-to-clone", "0.5"],
}
QUIET = ["--no-record", "--num-envs", "4", "--num-steps", "16", "--hidden-size", "8", "--eval-every", "0"]
MADE = {  # what other commands leave behind, and what reads it
    "demos": ["demonstrate", "1v1Restricted", "--episodes", "4", "--keep", "all", "--out", "{out}"],
    "clone": ["clone", "{demos}", "--epochs", "2", "--ppo.hidden-size", "8", "--out", "{out}"],
    "compared": [
        *("compare", TASK, "--methods", "dr", "plr", "--seeds", "1", "--episodes", "4", "--levels", "0"),
        *(*QUIET, "--total-env-steps", "128", "--processes", "1", "--out", "{out}"),
    ],
}
READERS = {
    "demos": (["clone", "{run}", "--epochs", "1", "--ppo.hidden-size", "8", "--out", "{run}-child"], MADE["demos"]),
    "clone": (MADE["clone"], ["evaluate", "{run}", "--episodes", "2", "--levels", "0"]),
    "compared": (MADE["compared"],),
}
KINDS = [*RUNS, *MADE]
SLOWER = 20  # times, to give a folder to a command
TEXTS = (".json", ".csv", ".scenic")
WORD = re.compile(r"[\w.+-]+")
WORDS = ("nan", "inf", "-1", "0", "1e999", "9" * 30, "x", '"', "[", "null", "0.5", "é", "\\ud800", "''")
COMMANDS = (
    ["evaluate", "{run}", "--episodes", "2", "--levels", "0"],
    ["evaluate", "{run}", "--gallery", "--gallery-replays", "3"],
    ["train", "--resume", "{run}", "--total-env-steps", "1_200"],
    ["train", TASK, "--method", "dr", "--from", "{run}", *SETTINGS, "--total-env-steps", "128", "--out", "{run}-child"],
)


def make_run(folder: Path, steps: int = 1_000, kind: str = "run") -> Path:
    """Train a small run."""
    path = folder / kind
    if not path.exists():
        words = [word.format(remembering=folder / "remembering") for word in RUNS[kind]]
        if "--from" in words:
            make_run(folder, steps, "remembering")
        words = ["train", *SETTINGS, "--total-env-steps", str(steps), *words]
        code, said = quietly([*words, "--out", str(path)])
        assert code == 0, said
    return path


def make(folder: Path, kind: str) -> Path:
    """Have a command make what another one reads."""
    path = folder / kind
    if not path.exists():
        if any("{demos}" in word for word in MADE[kind]):
            make(folder, "demos")
        code, said = quietly([word.format(out=path, demos=folder / "demos") for word in MADE[kind]])
        assert code == 0, said
    return path


@contextmanager
def undrawn() -> Iterator[None]:
    """Have pictures written and not drawn, which would take most of the time."""
    from matplotlib.figure import Figure

    from regista.experiments.pictures import curves, plots

    before = curves.learning_curves, Figure.savefig, Figure.tight_layout
    curves.learning_curves = lambda runs, path, *_, **__: plots.save(Figure(), path)  # type: ignore[assignment]
    Figure.savefig = lambda self, drawn, **_: drawn.write(bytes(10_000))  # type: ignore[method-assign]
    Figure.tight_layout = lambda self, **_: None  # type: ignore[method-assign]
    try:
        yield
    finally:
        curves.learning_curves, Figure.savefig, Figure.tight_layout = before  # type: ignore[method-assign]


def quietly(words: list[str]) -> tuple[int, str]:
    """Run a command in this process; return its exit code and what it wrote on stderr."""
    said = io.StringIO()
    with redirect_stdout(io.StringIO()), redirect_stderr(said), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return main(words), said.getvalue()


class Folder:
    """What a command has left behind, and a copy of it to be damaged that commands read."""

    def __init__(self, folder: Path, kind: str, made: Path | None = None) -> None:
        self.run, self.copy, self.folder = made or make(folder, kind), folder / f"{kind}-copy", folder
        self.whole, self.commands = contents(self.run), READERS.get(kind, COMMANDS)
        self.names = sorted(name for name in self.whole if not name.endswith((".rrd", ".png", ".log", ".md")))
        self.restore()

    def restore(self) -> None:
        """Make the copy whole again."""
        left = contents(self.copy) if self.copy.exists() else {}
        for name in left.keys() - self.whole.keys():
            (self.copy / name).unlink()
        for name, content in self.whole.items():
            file = self.copy / name
            file.parent.mkdir(parents=True, exist_ok=True)
            if not file.exists() or file.read_bytes() != content:
                file.write_bytes(content)

    def attempt(self, rng: np.random.Generator) -> str:
        """Damage one file of the copy and go on from it. Raises AssertionError for any harm."""
        file = self.copy / str(rng.choice(self.names))
        if file.suffix == ".pt" and rng.random() < 0.7:
            self.save_altered(file, rng)
        elif file.suffix in TEXTS and rng.random() < 0.5:
            file.write_text(with_word(file.read_text(), rng))
        else:
            file.write_bytes(damaged(file.read_bytes(), rng))
        if rng.random() < MISSING:
            (self.copy / str(rng.choice(self.names))).unlink()
        before, began, read = contents(self.copy), time.process_time(), self.reader(rng)
        try:
            outcome = read(rng)
        except (CommandError, CheckpointError, OSError) as error:
            assert "\n" not in str(error).strip() and len(str(error)) < 2_000, error
            outcome = REFUSED
        except AssertionError:
            raise
        except Exception as error:
            raise AssertionError(f"{file}: {read.__name__}: {traceback.format_exc()[-1_500:]}") from error
        if outcome == REFUSED:
            after = contents(self.copy)
            other = sorted(name for name in before.keys() | after.keys() if before.get(name) != after.get(name))
            assert not other, f"{file.name}: {read.__name__} refused it, and {', '.join(other)} was overwritten"
        spent = time.process_time() - began
        assert spent < (LONGER if read == self.command else SECONDS), f"{file.name}: {read.__name__} took {spent:.1f} s"
        self.restore()
        return outcome

    def reader(self, rng: np.random.Generator) -> Callable[[np.random.Generator], str]:
        """Return who reads it."""
        return self.command

    def command(self, rng: np.random.Generator) -> str:
        """Give the folder to a command."""
        typed = self.commands[rng.integers(len(self.commands))]
        words = [word.format(run=self.copy, out=self.copy, demos=self.folder / "demos") for word in typed]
        shutil.rmtree(f"{self.copy}-child", ignore_errors=True)
        code, said = quietly(words)
        told = [line for line in said.splitlines() if line.startswith("regista: ")]
        assert code in (0, 1, 2) and (code == 0 or told), f"{' '.join(words[:2])}: exit code {code}: {said[-1_000:]}"
        return WENT_ON if code == 0 else REFUSED

    def save_altered(self, file: Path, rng: np.random.Generator) -> None:
        """Write a whole checkpoint of which one entry, however deep, is another one."""
        content = torch.load(self.run / file.relative_to(self.copy), weights_only=True)
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


class Target(Folder):
    """A run, and a method of its kind that can take its checkpoint again and again."""

    def __init__(self, folder: Path, kind: str = "run") -> None:
        super().__init__(folder, kind, make_run(folder, kind=kind))
        self.names = [name for name in (*FILES, *MORE) if name in self.whole]
        config = RunFolder.open(self.run).config
        make = build.find_game(config.minigame).task(config).make
        self.upomdp = build.make_upomdp(make, config.num_envs, config.seed)
        self.config = config
        self.method = build.make_method(config, self.upomdp)
        self.quick = config.engine is None

    def reader(self, rng: np.random.Generator) -> Callable[[np.random.Generator], str]:
        """Return who reads it: mostly what takes no processes and no pictures."""
        kind = rng.random()
        return self.go_on if kind < 0.85 else self.load if kind < 0.98 else self.command

    def go_on(self, rng: np.random.Generator) -> str:
        """Do what `train --resume` does before its first update; where that takes milliseconds, now and then it too."""
        run = RunFolder.open(self.copy)
        if not run.checkpoint.exists():  # it begins anew, and not with what the last attempt has left in it
            self.method = build.make_method(self.config, self.upomdp)
        read_columns(run.metrics.path), read_levels(run.path)
        origin.begin_with(run, self.method)
        restore(run, self.method)
        if self.quick and rng.random() < UPDATED:
            before = contents(self.copy)
            try:
                self.method.update()
            except Exception as error:
                if type(error).__name__ not in USERS:
                    raise
                assert contents(self.copy) == before
                return FAULTED
        return WENT_ON

    def load(self, _: np.random.Generator) -> str:
        """Have the student of the checkpoint play."""
        policy = load_policy(self.copy)
        try:
            policy.act(np.zeros((3, *policy.shape), np.float32))
        except (FloatingPointError, ValueError) as error:  # weights that are no numbers
            assert "finite" in str(error) or "NaN" in str(error), traceback.format_exc()
            return REFUSED
        return WENT_ON


def with_word(text: str, rng: np.random.Generator) -> str:
    """Return a text in which a word or number is another one."""
    words = list(WORD.finditer(text))
    if not words:
        return "x"
    place = words[rng.integers(len(words))]
    return text[: place.start()] + str(rng.choice(WORDS)) + text[place.end() :]


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files but those that tell what went wrong in another process, by name."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".log"]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@cache
def target(folder: Path, kind: str) -> Folder:
    """Return what is damaged in this suite, made once."""
    return Folder(folder, kind) if kind in MADE else Target(folder, kind)


def attack(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Damage so many run folders of one kind; return how many went on and how many were refused."""
    rng, counts = np.random.default_rng(seed), {WENT_ON: 0, REFUSED: 0, FAULTED: 0}
    kind = KINDS[seed % len(KINDS)]
    with undrawn(), redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        attacked = target(folder, kind)
        attacked.restore()
        for _ in range(count // SLOWER if kind in MADE else count):
            counts[attacked.attempt(rng)] += 1
    return counts


if __name__ == "__main__":
    print(attack(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])))
