"""`regista probe`: compare methods on `ued.probes.Frontier`, whose answer is known, in minutes.

    regista probe --methods dr paired_literal paired plr accel --seeds 10

On the frontier, domain randomisation wastes most of its steps: nearly all levels are too long for what the student
knows. A method that finds the levels at the edge of it goes on learning. The score is the mean success rate over one
level of each length, which is the share of the turns that the student knows.
Read next: `ued.probes`, the levels; `ued.methods`, the methods.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from experiments.pictures import plots, results_page
from experiments.run import arguments, build
from experiments.run.arguments import group
from experiments.run.config import TrainConfig
from experiments.run.progress import Progress
from experiments.run.signals import held_back
from experiments.run.table import cannot_write
from experiments.run.workers import processes
from ued.config import BufferConfig, Checked, PLRConfig, PPOConfig, RepairedConfig, setting

if TYPE_CHECKING:
    from ued.statistics import Interval

DESCRIPTION = "Compare methods on a probe where levels at the frontier of a student's skill are rare."
CHOSEN = (
    *("minigame", "method", "seed", "threads", "checkpoint_seconds", "env"),
    *("record", "record_rollouts", "record_limit"),
)
TESTS = 20  # evaluations of a run
EPISODES = 5  # on each test level, in each of them


def probe_run() -> TrainConfig:
    """Return the settings of a run on the probe: short episodes, few weights, small buffers.

    PAIRED mixes no random levels in: here they teach nothing, and none that is known is forgotten on longer ones.
    """
    buffer = BufferConfig(capacity=256)
    groups = {item.name: item.default_factory() for item in fields(TrainConfig) if callable(item.default_factory)}
    kinds = PLRConfig | RepairedConfig
    with_buffer = {
        name: replace(settings, buffer=buffer) for name, settings in groups.items() if isinstance(settings, kinds)
    }
    alone = {name: replace(with_buffer.get(name, groups[name]), dr_fraction=0.0) for name in ("paired", "repaired")}
    ppo = PPOConfig(
        num_steps=64, learning_rate=2e-3, gamma=0.99, num_minibatches=4, update_epochs=4, ent_coef=0.05, hidden_size=64
    )
    return TrainConfig(total_env_steps=200_000, num_envs=32, ppo=ppo, **with_buffer | alone)


@dataclass(frozen=True)
class ProbeConfig(Checked):
    """What is typed after `regista probe`."""

    methods: tuple[str, ...] = setting(
        ("dr", "minimax", "paired_literal", "paired", "self_regret", "repaired", "plr", "robust_plr", "accel"),
        "methods to compare; the differences are to the first",
    )
    seeds: int = setting(10, "runs of each method, with seeds 0, 1, ...", ">=1")
    longest: int = setting(15, "length of the longest path", ">=1")
    dim: int = setting(4, "columns of theta; the more, the rarer short paths are")
    processes: int = setting(0, "runs at a time; 0: one per core")
    out: Path = setting(Path("runs/probe"), "folder of the table, the curves and the picture")
    train: TrainConfig = group(probe_run, "each run", without=CHOSEN)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.dim < 2:
            raise ValueError(f"dim must be at least 2, got {self.dim}")


@dataclass(frozen=True)
class Run:
    """A finished run: its score at each of its evaluations, and what it simulated."""

    method: str
    seed: int
    env_steps: list[int]
    scores: list[float]
    updates: int


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = arguments.parse(ProbeConfig(), argv, "probe", DESCRIPTION)
    for method in config.methods:
        build.find_method(method)
    runs = run_all(config)
    table = render(runs, config.methods, config.longest)
    try:
        config.out.mkdir(parents=True, exist_ok=True)
        (config.out / "table.md").write_text(table + "\n")
        save_csv(runs, config.out / "curves.csv")
    except OSError as error:
        raise cannot_write(config.out, error) from error
    draw(runs, config.methods, config.out / "curves.png")
    heading = f"The frontier: {plots.listed(config.methods)}"
    pictures = {"Share of the turns known, over simulated steps": "curves.png"}
    results_page.write_page(config.out, heading, ["probe", *argv], table, pictures)
    print(table)
    print(f"\n{config.out}/table.md, curves.csv, curves.png")
    return 0


def run_all(config: ProbeConfig) -> list[Run]:
    """Train every method with every seed, several at a time."""
    configs = [
        replace(config.train, method=method, seed=seed) for seed in range(config.seeds) for method in config.methods
    ]
    progress = Progress(len(configs) * config.train.total_env_steps)
    runs: list[Run] = []
    workers = config.processes or os.cpu_count() or 1
    with processes(workers) as pool:
        with held_back():
            futures = [pool.submit(run_one, run, config.longest, config.dim) for run in configs]
        for future in as_completed(futures):
            runs.append(future.result())
            progress.show(len(runs) * config.train.total_env_steps)
    progress.finish(f"{len(runs)} runs")
    return sorted(runs, key=lambda run: (config.methods.index(run.method), run.seed))


def run_one(config: TrainConfig, longest: int, dim: int) -> Run:
    """Train one method with one seed, and test its student on the way."""
    from ued.evaluation import evaluate
    from ued.probes import Frontier

    method = build.make_method(config, Frontier(config.num_envs, longest, dim))
    test = Frontier(config.num_envs, longest, dim)
    test.reset(seed=0)
    levels = test.test_levels()
    steps: list[int] = []
    scores: list[float] = []
    while method.env_steps < config.total_env_steps:
        method.update()
        if method.env_steps >= (len(steps) + 1) * config.total_env_steps / TESTS:
            steps.append(method.env_steps)
            scores.append(float(evaluate(method.student, test, EPISODES * longest, 1, levels).returns.mean()))
    return Run(config.method, config.seed, steps, scores, method.updates)


def render(runs: Sequence[Run], methods: Sequence[str], longest: int) -> str:
    """Return a Markdown table: score of each method with its interval over runs, and the difference to the first."""
    from ued.statistics import bootstrap, iqm, probability_of_improvement

    rng = np.random.default_rng(0)
    final = {name: np.array([run.scores[-1] for run in runs if run.method == name]) for name in methods}
    base = bootstrap(final[methods[0]], rng)
    rows = [["method", "turns known", "mean score", "IQM", f"minus {methods[0]}", "P(better)", "env_steps", "updates"]]
    for name in methods:
        mine = bootstrap(final[name], rng)
        steps = [(run.env_steps[-1], run.updates) for run in runs if run.method == name]
        rows.append(
            [
                name,
                f"{longest * mine.estimate:.1f} of {longest}",
                _cell(mine.interval()),
                f"{iqm(final[name]):.2f}",
                "" if name == methods[0] else _cell((mine - base).interval(), (-1.0, 1.0), "+"),
                "" if name == methods[0] else _cell(probability_of_improvement(final[name], final[methods[0]])),
                *(f"{round(np.mean(column)):_}" for column in zip(*steps, strict=True)),
            ]
        )
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


def _cell(interval: Interval, bounds: tuple[float, float] = (0.0, 1.0), sign: str = "") -> str:
    if np.isnan(interval.low):  # of a single run
        return f"{interval.estimate:{sign}.2f}"
    low, high = (min(max(end, bounds[0]), bounds[1]) for end in (interval.low, interval.high))
    return f"{interval.estimate:{sign}.2f} [{low:{sign}.2f}, {high:{sign}.2f}]"


def save_csv(runs: Sequence[Run], path: Path) -> None:
    """Write one row for each evaluation of each run."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["method", "seed", "env_steps", "score", "updates"])
        for run in runs:
            for steps, score in zip(run.env_steps, run.scores, strict=True):
                writer.writerow([run.method, run.seed, steps, round(score, 4), run.updates])


def draw(runs: Sequence[Run], methods: Sequence[str], path: Path) -> None:
    """Draw the score of each method over the steps simulated: mean over runs, and their middle half."""
    with plots.style():
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
        for name in methods:
            mine = [run for run in runs if run.method == name]
            count = min(len(run.scores) for run in mine)
            scores = np.array([run.scores[:count] for run in mine])
            steps = np.mean([run.env_steps[:count] for run in mine], 0)
            low, high = np.quantile(scores, [0.25, 0.75], axis=0)
            axes.plot(steps, scores.mean(0), color=plots.colour(name), label=plots.title(name))
            axes.fill_between(steps, low, high, color=plots.colour(name), alpha=0.15, linewidth=0)
        plots.label_steps(axes)
        axes.set_ylabel("share of the turns known")
        axes.set_ylim(0, 1)
        axes.legend(loc="upper left", fontsize=8)
        plots.save(figure, path)
