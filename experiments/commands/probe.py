"""`regista probe`: compare methods on `ued.probes.Frontier`, whose answer is known, in minutes.

    regista probe --methods dr paired_literal paired plr accel --seeds 10

On the frontier, domain randomisation wastes most of its steps: nearly all levels are too long for what the student
knows. A method that finds the levels at the edge of it goes on learning. The score is the mean success rate over one
level of each length, which is the share of the turns that the student knows.
Read next: `ued.probes`, the levels; `ued.methods`, the methods.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.pictures import plots
from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group
from regista.experiments.run.config import TrainConfig, to_dict
from regista.experiments.run.errors import DAMAGE, UsageError, nearest
from regista.experiments.run.progress import Progress
from regista.experiments.run.report import save_rows, write_text
from regista.experiments.run.signals import StopRequest, held_back
from regista.experiments.run.table import cannot_write
from regista.experiments.run.workers import LaunchConfig, processes, train_unfinished
from ued.config import BufferConfig, Checked, PLRConfig, PPOConfig, RepairedConfig, setting
from ued.core.files import write_whole

if TYPE_CHECKING:
    from ued.statistics import Interval

DESCRIPTION = "Compare methods on a probe where levels at the frontier of a student's skill are rare."
CHOSEN = (
    *("minigame", "method", "seed", "threads", "checkpoint_seconds", "env"),
    *("record", "record_rollouts", "record_limit"),
)
INTERVALS = "95% intervals: bootstrap over runs, of P(better) Newcombe's; methods with fewer than 5 runs have none."
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
    seeds: int = setting(10, "runs of each method, with seeds 0, 1, ...", ">=1", most=10_000)
    longest: int = setting(15, "length of the longest path", ">=1", most=1_000)
    dim: int = setting(4, "columns of theta; the more, the rarer short paths are", most=1_000, least=2)
    out: Path = setting(Path("runs/probe"), "folder of the table, the curves and the picture")
    only: str | None = setting(None, "train one run alone, such as plr-3, and make no table")
    launch: LaunchConfig = group(LaunchConfig, "who trains the runs", prefix="")
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


@dataclass(frozen=True)
class ProbeJob:
    """A run that is to be trained, and the folder that keeps what came of it: `run.json`, with its settings.

    Attributes:
        path: the folder.
        config: settings of training.
        longest, dim: of the probe.
        typed: what was typed behind `regista probe`.
    """

    path: Path
    config: TrainConfig
    longest: int
    dim: int
    typed: tuple[str, ...]

    @property
    def words(self) -> list[str]:
        """What is typed behind `regista` to train it alone, wherever that is."""
        only = ["--only", self.path.name, "--out", str(self.path.parent.resolve()), "--launcher", "local"]
        return ["probe", *self.typed, *only]

    def settings(self) -> dict[str, Any]:
        """Return what determines the run, as JSON has it."""
        return json.loads(json.dumps({**to_dict(self.config), "longest": self.longest, "dim": self.dim}))

    def known(self) -> Run | None:
        """Return the finished run, None if it is not there or has other settings."""
        try:
            kept = json.loads((self.path / "run.json").read_text())
            run = Run(**kept["run"])
            numbers = np.array([run.env_steps, run.scores], float)  # not of what is damaged
            whole = kept["settings"] == self.settings() and np.isfinite([*numbers.flat, run.updates, run.seed]).all()
            return run if whole and run.method == self.config.method else None
        except (OSError, *DAMAGE):
            return None

    def finished(self) -> bool:
        """Return whether there is nothing to train any more."""
        return self.known() is not None

    def env_steps(self) -> int:
        """Return the steps that are done: all or none, for nothing is kept of a run that ends early."""
        return self.config.total_env_steps if self.finished() else 0

    def train(self) -> None:
        """Train, and keep what came of it."""
        run = run_one(self.config, self.longest, self.dim)
        kept = {"settings": self.settings(), "run": asdict(run)}
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            write_whole(self.path / "run.json", json.dumps(kept))
        except OSError as error:
            raise cannot_write(self.path, error) from error


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = arguments.parse(ProbeConfig(), argv, "probe", DESCRIPTION)
    jobs = plan(config, argv)
    if config.only is not None:
        jobs[config.only].train()
        return 0
    if config.launch.launcher == "local":
        train_here([job for job in jobs.values() if not job.finished()], config.launch)
    else:
        with StopRequest() as stop:
            trained = train_unfinished(list(jobs.values()), config.launch, stop)
        if not trained:
            return stop.exit_code
    runs = [run for run in (job.known() for job in jobs.values()) if run is not None]
    table = render(runs, config.methods, config.longest)
    try:
        config.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(config.out, error) from error
    write_text(config.out / "table.md", table + "\n")
    save_csv(runs, config.out / "curves.csv")
    draw(runs, config.methods, config.out / "curves.png")
    print(table)
    print(f"\n{config.out}/table.md, curves.csv, curves.png")
    return 0


def plan(config: ProbeConfig, argv: Sequence[str]) -> dict[str, ProbeJob]:
    """Return every method with every seed, by name. Raises `UsageError` for an unknown method or run."""
    jobs = {}
    for method in map(build.find_method, config.methods):
        for seed in range(config.seeds):
            train = replace(config.train, method=method, seed=seed)
            path = config.out / f"{method}-{seed}"
            jobs[path.name] = ProbeJob(path, train, config.longest, config.dim, tuple(argv))
    if config.only is not None and config.only not in jobs:
        raise UsageError(f"no run {config.only!r}{nearest(config.only, jobs)}; there are {', '.join(jobs)}")
    return jobs


def train_here(jobs: Sequence[ProbeJob], how: LaunchConfig) -> None:
    """Train runs on this machine, several at a time: they are short, and share processes."""
    if not jobs:
        return
    progress = Progress(sum(job.config.total_env_steps for job in jobs))
    done = 0
    with processes(how.at_a_time(1, len(jobs))) as pool:
        with held_back():
            futures = {pool.submit(job.train): job for job in jobs}
        for future in as_completed(futures):
            future.result()
            done += futures[future].config.total_env_steps
            progress.show(done)
    progress.finish(f"{len(jobs)} runs")


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
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:], "", INTERVALS])


def _cell(interval: Interval, bounds: tuple[float, float] = (0.0, 1.0), sign: str = "") -> str:
    if not interval.known:  # of few runs
        return f"{interval.estimate:{sign}.2f}"
    low, high = (min(max(end, bounds[0]), bounds[1]) for end in (interval.low, interval.high))
    return f"{interval.estimate:{sign}.2f} [{low:{sign}.2f}, {high:{sign}.2f}]"


def save_csv(runs: Sequence[Run], path: Path) -> None:
    """Write one row for each evaluation of each run."""
    columns = ("method", "seed", "env_steps", "score", "updates")
    rows = [
        dict(zip(columns, (run.method, run.seed, steps, round(score, 4), run.updates), strict=True))
        for run in runs
        for steps, score in zip(run.env_steps, run.scores, strict=True)
    ]
    save_rows(rows, columns, path)


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
