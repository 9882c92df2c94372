"""The tables and the picture of the maze benchmark, from the rows that `lab.mazes` stored.

    python -m lab.maze_tables               # print them
    python -m lab.maze_tables --publish     # write them into docs/benchmarks/maze.md, with the picture

Intervals are 95% bootstrap intervals over whole runs. Published rates are DCD's (`lab/results/maze_published.csv`).
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from lab.mazes import PARTS, ROWS
from lab.studies.cells import percent
from regista.experiments.pictures import keys, plots
from regista.experiments.run import results as estimate
from regista.experiments.run import significance
from regista.experiments.run.report import as_markdown, write_text
from regista.experiments.run.results import LevelResult, Result, select, unique
from regista.experiments.run.significance import difference_of_means, points
from regista.experiments.run.table import read_rows
from ued.core.task import TRAINING_SCENE
from ued.statistics import Difference, bootstrap, detectable

PAGE, PICTURE = Path("docs/benchmarks/maze.md"), Path("docs/pictures/maze_curves.png")
TITLES = {  # of rows that are not named after a method
    "paired_steps": "PAIRED, steps",
    "paired_direct": "PAIRED, direct",
    "accel_empty": "ACCEL from empty mazes",
    "mna": "PLR⊥, score MNA",
    "general_sfl": "SFL, generalized learnability",
    "published_plr": "PLR⊥, temperature 0.1",
}
PUBLISHED = {"paired_steps": "paired", "accel_empty": "accel"}  # our row: published row, if the names differ
EQUAL = 10_000_000  # student steps at which methods are compared
APART = 0.02  # gap between the intervals at the ends of curves, as a share of a curve
BUDGETS = (25_000_000, 100_000_000, 250_000_000)  # budgets at which single long runs are shown

COMMAND = "`python -m lab.maze_tables`."

Table = list[list[str]]


class Study:
    """The rows of one part: test mazes, random mazes, curves, and the published rates of the same walls."""

    def __init__(self, part: str) -> None:
        self.part = part
        self.tests = [result(row) for row in rows("tests", part) if row["maze"] != TRAINING_SCENE]
        self.levels = [level_result(row) for row in rows("levels", part)]
        self.curves = rows("curves", part)
        self.published = {
            (row["method"], row["maze"]): float(row["solved"])
            for row in read_rows(ROWS / "maze_published.csv")
            if row["walls"] == PARTS[part].walls
        }

    @property
    def methods(self) -> list[str]:
        """The trained rows, the reference first."""
        known = dict.fromkeys(["dr", *PARTS[self.part].rows])
        return [name for name in known if any(row.method == name for row in self.tests)]

    @property
    def mazes(self) -> list[str]:
        return unique([row.scene for row in self.tests])

    def random(self, method: str) -> list[LevelResult]:
        """Return the rows of a method's runs on random mazes."""
        return [row for row in self.levels if row.method == method]

    def theirs(self, method: str, maze: str) -> float | None:
        """Return the published rate of a method on a maze."""
        return self.published.get((PUBLISHED.get(method, method), maze))


def rows(kind: str, part: str) -> list[dict[str, str]]:
    """Return the stored rows of a part, and those of its reference."""
    beside = PARTS[part].beside
    path = ROWS / f"maze_{kind}.csv"
    return [
        row
        for row in (read_rows(path) if path.exists() else [])
        if row["part"] == part or (row["part"] == beside and row["method"] == "dr")
    ]


def result(row: Mapping[str, str]) -> Result:
    """Make a result of a stored row, with 0 in fields that the tables do not use."""
    counts = (int(row[name]) for name in ("seed", "episodes", "goals", "env_steps"))
    seed, episodes, goals, env_steps = counts
    return Result(row["method"], seed, row["maze"], episodes, float(row["mean_return"]), 0.0, goals, 0.0, env_steps, 0)


def level_result(row: Mapping[str, str]) -> LevelResult:
    """Make the result on random mazes of a stored row."""
    counts = (int(row[name]) for name in ("seed", "levels", "episodes"))
    return LevelResult(row["method"], *counts, *(float(row[name]) for name in ("goal_rate", "cvar10", "cvar10_error")))


# ---------------------------------------------------------------- tables


def summary(study: Study) -> Table:
    """Return a row for each method: test mazes at the end and in the last quarter of training, and random mazes."""
    common = [name for name in study.mazes if study.theirs("dr", name) is not None]
    table = [
        ["method", "all test mazes", "IQM", "minus DR", "last quarter", "minus DR"]
        + [f"{len(common)} mazes", "published", "random mazes", "worst tenth", "minus DR"]
    ]
    found = (test_gains(study), late_gains(study), worst_gains(study))
    marks = iter(significance.marks([gain for gains in found for gain in gains.values()]))
    on_tests, late, on_worst = ({name: points(gain, next(marks)) for name, gain in gains.items()} for gains in found)
    for name in study.methods:
        mine, few = scores(study, name, study.mazes), scores(study, name, common)
        table.append(
            [
                title(name),
                percent(estimate.mean_score(mine)),
                percent(estimate.iqm_score(mine)),
                on_tests.get(name, ""),
                percent(bootstrap(late_rates(study, name), np.random.default_rng(0)).interval()),
                late.get(name, ""),
                percent(estimate.mean_score(few)),
                published_mean(study, name, common),
                percent(estimate.level_rate(study.random(name))),
                percent(estimate.level_cvar(study.random(name))),
                on_worst.get(name, ""),
            ]
        )
    return table


def late_rates(study: Study, method: str) -> np.ndarray:
    """Return the share of test mazes solved by each run `[R]`, the mean of the evaluations in its last quarter.

    A single evaluation is noisy: a policy wins a maze always or never, and that changes between two evaluations.
    """
    runs: dict[str, list[tuple[int, float]]] = {}
    for row in study.curves:
        if row["method"] == method:
            runs.setdefault(row["seed"], []).append((int(row["env_steps"]), float(row["solved"])))
    return np.array([last_quarter(curve, max(steps for steps, _ in curve)) for curve in runs.values()])


def last_quarter(curve: Iterable[tuple[int, float]], budget: int) -> float:
    """Return the mean rate of the evaluations in the last quarter of a budget, each given as steps and rate.

    An evaluation takes place at the end of an update, shortly after the step for which it is planned.
    """
    return float(np.mean([rate for at, rate in curve if 0.74 * budget < at < 1.01 * budget]))


def late_gains(study: Study) -> dict[str, Difference]:
    """Return the difference of each method to DR in the last quarter of training."""
    base = late_rates(study, "dr")
    return {name: difference_of_means(late_rates(study, name), base) for name in study.methods if name != "dr"}


def test_gains(study: Study) -> dict[str, Difference]:
    """Return the difference of each method to DR on the test mazes."""
    base = scores(study, "dr", study.mazes)
    return {
        name: estimate.score_advantage(scores(study, name, study.mazes), base) for name in study.methods if name != "dr"
    }


def worst_gains(study: Study) -> dict[str, Difference]:
    """Return the difference of each method to DR on the worst tenth of random mazes."""
    base = study.random("dr")
    return {name: estimate.level_advantage(study.random(name), base) for name in study.methods if name != "dr"}


def note(study: Study) -> str:
    """Return the note below the summary."""
    gains = [gain for gains in (test_gains, late_gains, worst_gains) for gain in gains(study).values()]
    counts = [len(study.random(name)) for name in study.methods]
    sizes = [
        estimate.detectable_score([scores(study, name, study.mazes) for name in study.methods]),
        detectable([late_rates(study, name) for name in study.methods]),
        estimate.detectable_level([study.random(name) for name in study.methods]),
    ]
    seen = significance.visible([100 * size for size in sizes], counts, "{:.0f} points")
    return significance.sentences(significance.legend([gain.p for gain in gains]), seen)


def by_maze(study: Study) -> Table:
    """Return a row for each maze and a column for each method: our rate with its interval, then the published rate."""
    table = [["maze", *map(title, study.methods)]]
    for maze in study.mazes:
        cells = []
        for name in study.methods:
            theirs = study.theirs(name, maze)
            ours = percent(estimate.goal_rate(select(study.tests, name, maze)))
            cells.append(ours if theirs is None else f"{ours} ({theirs:.0%})")
        table.append([maze, *cells])
    return table


def equal_steps(study: Study, steps: int = EQUAL) -> Table:
    """Return the share of solved test mazes of each method after its student has learned from this number of steps."""
    table = [["method", "student steps", "simulated steps", "test mazes", "minus DR"]]
    found = {name: at_steps(study, name, steps) for name in study.methods}
    solved = {name: [float(row["solved"]) for row in runs] for name, runs in found.items()}
    gains = {name: difference_of_means(mine, solved["dr"]) for name, mine in solved.items() if name != "dr"}
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    for name, runs in found.items():
        trained, simulated = (np.mean([int(row[key]) for row in runs]) for key in ("trained_steps", "env_steps"))
        gain = points(gains[name], marks[name]) if name in gains else ""
        told = percent(bootstrap(np.array(solved[name]), np.random.default_rng(0)).interval())
        table.append([title(name), f"{trained / 1e6:.1f}M", f"{simulated / 1e6:.1f}M", told, gain])
    return table


def at_steps(study: Study, method: str, steps: int) -> list[dict[str, str]]:
    """Return the evaluation of each run of a method nearest to `steps` student steps."""
    mine = [row for row in study.curves if row["method"] == method]
    seeds = unique([row["seed"] for row in mine])
    each = ([row for row in mine if row["seed"] == seed] for seed in seeds)
    return [min(run, key=lambda row: abs(int(row["trained_steps"]) - steps)) for run in each]


def long_runs(study: Study, budgets: Sequence[int] = BUDGETS) -> Table:
    """Return a row for each single long run: rates in the last quarter of several budgets, and those at the end."""
    common = [name for name in study.mazes if study.theirs("dr", name) is not None]
    table = [["method", *(f"{budget / 1e6:.0f}M" for budget in budgets), "at the end"]]
    table[0] += [f"{len(common)} mazes", "published", "random mazes", "worst tenth"]
    for name in study.methods:
        curve = [(int(row["env_steps"]), float(row["solved"])) for row in study.curves if row["method"] == name]
        [levels] = study.random(name)
        at_end = (estimate.mean_score(scores(study, name, mazes)).estimate for mazes in (study.mazes, common))
        rates = [f"{rate:.0%}" for rate in (*(last_quarter(curve, budget) for budget in budgets), *at_end)]
        cells = [*rates, published_mean(study, name, common), f"{levels.goal_rate:.0%}", f"{levels.cvar10:.0%}"]
        table.append([title(name), *cells])
    return table


def published_mean(study: Study, method: str, mazes: Iterable[str]) -> str:
    """Return the mean of a method's published rates on some mazes; empty if one of these rates is missing."""
    rates = [study.theirs(method, maze) for maze in mazes]
    return "" if None in rates else f"{np.mean(rates):.0%}"  # type: ignore[arg-type]


def tuning() -> Table:
    """Return for each method the number of settings tried with one epoch, and the best one on the worst tenth."""
    table = [["method", "settings", "best", "random mazes", "worst tenth"]]
    tried: dict[str, list[dict[str, str]]] = {}
    for row in read_rows(ROWS / "maze_tuning.csv"):
        if row["update_epochs"] == "1":
            tried.setdefault(kind_of(row), []).append(row)
    for kind, mine in tried.items():
        best = max(mine, key=lambda row: float(row["worst_tenth"]))
        chosen = f"learning rate {best['learning_rate']}, entropy {best['ent_coef']}"
        own = best["setting"].partition(" ")[2] if best["method"] == "paired" else best["setting"]
        rates = [f"{float(best[name]):.0%}" for name in ("random_levels", "worst_tenth")]
        table.append([kind, str(len(mine)), ", ".join(filter(None, (chosen, own))), *rates])
    return table


def kind_of(row: Mapping[str, str]) -> str:
    """Return the method of a tuning row as named in tables; PAIRED has two kinds of adversary."""
    title = plots.title(row["method"])
    return f"{title}, {row['setting'].partition(' ')[0]}" if row["method"] == "paired" else title


def scores(study: Study, method: str, mazes: Iterable[str]) -> estimate.Scores:
    """Return a method's rates on some mazes."""
    chosen = set(mazes)
    return estimate.scores([row for row in study.tests if row.scene in chosen], method)


def title(row: str) -> str:
    """Return the name of a row in tables and legends."""
    return TITLES.get(row) or plots.title(row)


# ---------------------------------------------------------------- picture


def method_of(part: str, row: str) -> str:
    """Return the method of a row of a part."""
    words = PARTS[part].rows[row].split()
    return words[words.index("--method") + 1]


def draw(study: Study, path: Path) -> None:
    """Draw the solved test mazes over simulated steps and over student steps: means, and final intervals."""
    plots.distinguish({name: method_of(study.part, name) for name in study.methods if name not in plots.METHOD_COLORS})
    with plots.style():
        import matplotlib.pyplot as plt

        figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.9), layout="constrained", sharey=True)
        labels = ("simulated steps, all students", "steps that the student learned from")
        for axes, key, label in zip(panels, ("env_steps", "trained_steps"), labels, strict=True):
            known = [
                draw_method(axes, study, key, name, APART * (1 + index)) for index, name in enumerate(study.methods)
            ]
            axes.set_xlabel(label)
            axes.set_xlim(left=0)
            plots.rate_axis(axes)
            plots.shorten_steps(axes)
        panels[0].set_ylabel("share of test mazes solved")
        handles = keys.method_handles(study.methods, (keys.MEAN, *([keys.WHISKER] if any(known) else [])))
        for handle, name in zip(handles, study.methods, strict=False):
            handle.set_label(title(name))
        figure.legend(handles=handles, loc="outside upper left", ncols=5, fontsize=8)
        plots.save(figure, path)


def draw_method(axes: plots.Axes, study: Study, key: str, name: str, aside: float) -> bool:
    """Draw the mean over a method's runs, and the 95% interval of its last value; return whether the interval is known.

    `aside`: distance between the end of the curve and the interval, as a share of the curve.
    """
    curve = [row for row in study.curves if row["method"] == name]
    seeds = unique([row["seed"] for row in curve])
    runs = [[row for row in curve if row["seed"] == seed] for seed in seeds]
    count = min(map(len, runs))
    steps, solved = (np.array([[float(row[k]) for row in run[:count]] for run in runs]) for k in (key, "solved"))
    axes.plot(steps.mean(0), solved.mean(0), **plots.curve_look(name, len(study.methods)))
    end = bootstrap(solved[:, -1], np.random.default_rng(0)).interval()
    plots.whisker(axes, steps[:, -1].mean() * (1 + aside), end, name)
    return end.known


# ---------------------------------------------------------------- page


def sections() -> dict[str, str]:
    """Return the text of each generated section of the page, for the parts that have rows."""
    found = {"tuning": as_markdown(tuning())}
    for part in PARTS:
        study = Study(part)
        if study.methods and PARTS[part].seeds == 1:
            found[f"{part} runs"] = f"{as_markdown(long_runs(study))}\n\nOne run of each method. {COMMAND}"
        elif study.methods:
            counts = unique([str(len({row.seed for row in study.tests if row.method == m})) for m in study.methods])
            below = f"{' or '.join(counts)} runs of each method, {PARTS[part].env_steps // 10**6}M steps. {note(study)}"
            found[f"{part} summary"] = f"{as_markdown(summary(study))}\n\n{below} {COMMAND}"
            found[f"{part} mazes"] = as_markdown(by_maze(study))
            found[f"{part} student steps"] = as_markdown(equal_steps(study))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--publish", action="store_true", help="write the tables into the page, and the picture")
    typed = parser.parse_args()
    page = PAGE.read_text() if typed.publish else ""
    for name, text in sections().items():
        if not typed.publish:
            print(f"## {name}\n\n{text}\n")
        page = re.sub(rf"(<!-- {name} -->\n).*?(<!-- end -->)", rf"\g<1>{text}\n\g<2>", page, flags=re.DOTALL)
    if typed.publish:
        write_text(PAGE, page)
        if Study("main").methods:
            draw(Study("main"), PICTURE)


if __name__ == "__main__":
    main()
