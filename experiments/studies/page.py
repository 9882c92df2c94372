"""The page of the benchmark: tables and bar charts, ours beside the published, drawn from the CSV files alone.

Read next: `studies.rows`, what is in the files; `pictures.bars`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from experiments.pictures.bars import Bars, draw_bars
from experiments.run.progress import count
from experiments.run.report import as_markdown, write_text
from experiments.run.results import mean_return
from experiments.studies.rows import TRAIN, Row, load
from minigames.published import Published, find_published, published
from minigames.suites import BENCHMARK
from ued.statistics import Interval, spearman

FILES = "{preset}.csv"
PRESETS = {"fast": "features, an MLP 64 wide", "thesis": "stacked SMM, the network of Fig. 4.10, Table 4.2"}
OURS, THEIRS, TEST_OURS, TEST_THEIRS = "#2b6cb0", "#a9c4e4", "#d08a1d", "#f0d3a0"
OUT_OF_PLACE = 3  # games named beneath a rank correlation
INTERVALS = "95 % intervals: over runs and their episodes; of one run over its episodes alone"

FIGURE_2_7 = tuple(row.game for row in published() if row.source == "Fig. 2.7")
TESTED = tuple(game.name for game in BENCHMARK.values() if game.tests)
TABLE_4_1 = tuple(row.game for row in published() if row.agent == "light_cnn")


class Measured(NamedTuple):
    """The rows of one preset."""

    preset: str
    rows: Sequence[Row]

    def of(self, game: str, agent: str, scene: str) -> list[Row]:
        """Return the rows of an agent on a scene, one for each seed."""
        return [row for row in self.rows if (row.game, row.agent, row.scene) == (game, agent, scene)]

    def estimate(self, game: str, agent: str = "ppo", scene: str = TRAIN) -> Interval | None:
        """Estimate the goal difference of an agent on a scene, None where it was not measured."""
        found = self.of(game, agent, scene)
        return mean_return([row.result() for row in found]) if found else None


def write_page(results: Path, page: Path, pictures: Path) -> None:
    """Write the page and its pictures from all files of a folder. Raises `CommandError` if the disk refuses."""
    parts = [HEAD]
    for preset in PRESETS:
        rows = load(results / FILES.format(preset=preset))
        if rows:
            measured = Measured(preset, rows)
            parts += [f"## Preset `{preset}`: {PRESETS[preset]}", about(measured)]
            parts += [section(measured, page.parent, pictures) for section in SECTIONS]
    write_text(page, "\n\n".join(part for part in parts if part) + "\n")


HEAD = """\
# The benchmark of the thesis, made again

Goal differences per episode, of agents in our simulator beside what is published of Google Research Football. This page
is drawn from `experiments/studies/results` by `regista study`, which also makes what is missing:

```sh
regista study single --seeds 5 --hours 3           # the 13 games of Figure 2.7; after three hours call it again
regista study generalisation --seeds 3 --hours 3   # all 20 that have a test program
regista study single --preset thesis               # stacked SMM and the thesis's network
```"""


def about(measured: Measured) -> str:
    """Return what was run, on which commits, and how long it took."""
    runs = {(row.game, row.seed): row for row in measured.rows if row.agent == "ppo"}.values()
    games, seeds = {row.game for row in runs}, {row.seed for row in runs}
    steps = sorted({row.env_steps for row in runs})
    length = " to ".join(dict.fromkeys(count(each) for each in (steps[0], steps[-1]))) if steps else "no"
    spent = sum(row.seconds for row in runs) / 3600
    commits = ", ".join(sorted({row.commit for row in measured.rows} - {""}))
    return (
        f"{len(runs)} runs of {len(games)} games, {len(seeds)} seed{'s' * (len(seeds) != 1)}, {length} steps each, one "
        f"agent (`closest1`), paid for goals; {spent:.1f} hours of training in all. The simulator and the games were "
        f"those of {commits or 'no commit'}. {INTERVALS}."
    )


# ---------------------------------------------------------------- sections


def single(measured: Measured, folder: Path, pictures: Path) -> str:
    """Return the section of Figure 2.7: the 13 games, ours beside the published."""
    games = [game for game in FIGURE_2_7 if measured.of(game, "ppo", TRAIN)]
    if not games:
        return ""
    path = pictures / f"benchmark_single_{measured.preset}.png"
    bars = [_ours(measured, games, TRAIN, OURS, "ours"), _theirs(games, "train", THEIRS, "published")]
    draw_bars(games, bars, "PPO on the training scenes (thesis, Figure 2.7)", path)
    head = ["game", "uniform keys", "PPO", "runs", "published", "semi-expert", "published"]
    rows = [_single_row(measured, game) for game in games]
    parts = [
        "### One agent (Figure 2.7)",
        f"![PPO on the training scenes]({path.relative_to(folder)})",
        as_markdown([head, *rows]),
    ]
    return "\n\n".join([*parts, ranks(measured, games, "train")])


def generalisation(measured: Measured, folder: Path, pictures: Path) -> str:
    """Return the section of Figure 2.8: training scenes beside test scenes."""
    games = [game for game in TESTED if measured.of(game, "ppo", "test")]
    if not games:
        return ""
    path = pictures / f"benchmark_generalisation_{measured.preset}.png"
    bars = [
        _ours(measured, games, TRAIN, OURS, "train"),
        _ours(measured, games, "test", TEST_OURS, "test"),
        _theirs(games, "train", THEIRS, "train, published"),
        _theirs(games, "test", TEST_THEIRS, "test, published"),
    ]
    draw_bars(games, bars, "From training scenes to test scenes (thesis, Figure 2.8)", path)
    head = ["game", "train", "test", "train, published", "test, published", "uniform keys, test", "published"]
    rows = [_tested_row(measured, game) for game in games]
    parts = [
        "### From training to test scenes (Figure 2.8)",
        f"![Training and test scenes]({path.relative_to(folder)})",
        as_markdown([head, *rows]),
    ]
    return "\n\n".join([*parts, ranks(measured, games, "test")])


def networks(measured: Measured, folder: Path, pictures: Path) -> str:
    """Return the section of Table 4.1: ours beside both networks of the thesis."""
    games = [game for game in TABLE_4_1 if measured.of(game, "ppo", TRAIN)]
    if not games:
        return ""
    head = ["game", "ours", "light CNN, published", "Impala CNN, published"]
    rows = []
    for game in games:
        theirs = [_plain(find_published(game, agent)) for agent in ("light_cnn", "impala_cnn")]
        rows.append([game, _cell(measured.estimate(game)), *theirs])
    return "\n\n".join(["### Two networks (Table 4.1)", as_markdown([head, *rows])])


Section = Callable[[Measured, Path, Path], str]
SECTIONS: tuple[Section, ...] = (single, generalisation, networks)


def ranks(measured: Measured, games: Sequence[str], split: str) -> str:
    """Return Spearman's rank correlation with the published over the games, and which are most out of place."""
    pairs = {}
    for game in games:
        ours, told = measured.estimate(game, scene=split), find_published(game, "ppo", split)
        if ours is not None and told is not None:
            pairs[game] = (ours.estimate, told.goal_difference)
    if len(pairs) < 3:
        return ""
    mine, theirs = zip(*pairs.values(), strict=True)
    gap = {game: _place(mine, one) - _place(theirs, other) for game, (one, other) in pairs.items()}
    worst = sorted(gap, key=lambda game: -abs(gap[game]))[:OUT_OF_PLACE]
    moved = ", ".join(f"{game} ({gap[game]:+g} places)" for game in worst if gap[game])
    about = f" Most out of place, a plus where ours is easier: {moved}." if moved else ""
    return (
        f"Spearman's rank correlation with the published over {len(pairs)} games: {spearman(mine, theirs):.2f}.{about}"
    )


def _place(values: Sequence[float], value: float) -> float:
    """Return how many values are below one, an equal one counting one half."""
    return sum(0.5 * (other == value) + (other < value) for other in values)


# ---------------------------------------------------------------- rows and bars


def _single_row(measured: Measured, game: str) -> list[str]:
    runs = str(len(measured.of(game, "ppo", TRAIN)))
    told = [_cell(measured.estimate(game, "random")), _cell(measured.estimate(game)), runs]
    experts = [_cell(measured.estimate(game, "expert")), _plain(find_published(game, "expert"))]
    return [game, *told, _plain(find_published(game, "ppo")), *experts]


def _tested_row(measured: Measured, game: str) -> list[str]:
    ours = [_cell(measured.estimate(game, scene=scene)) for scene in (TRAIN, "test")]
    theirs = [_plain(find_published(game, "ppo", split)) for split in ("train", "test")]
    keys = [_cell(measured.estimate(game, "random", "test")), _plain(find_published(game, "random", "test"))]
    return [game, *ours, *theirs, *keys]


def _cell(interval: Interval | None) -> str:
    if interval is None:
        return ""
    return f"{interval.estimate:+.2f} [{interval.low:+.2f}, {interval.high:+.2f}]"


def _plain(row: Published | None) -> str:
    if row is None:
        return ""
    return f"{row.goal_difference:+.2f}" + ("" if row.interval is None else f" ± {row.interval:.2f}")


def _ours(measured: Measured, games: Sequence[str], scene: str, colour: str, label: str) -> Bars:
    nothing = Interval(float("nan"), float("nan"), float("nan"))
    found = [measured.estimate(game, scene=scene) or nothing for game in games]
    return Bars(label, colour, *zip(*found, strict=True))


def _theirs(games: Sequence[str], split: str, colour: str, label: str) -> Bars:
    found = [find_published(game, "ppo", split) for game in games]
    middles = [float("nan") if row is None else row.goal_difference for row in found]
    halves = [float("nan") if row is None or row.interval is None else row.interval for row in found]
    lows, highs = ([middle + side * half for middle, half in zip(middles, halves, strict=True)] for side in (-1, 1))
    return Bars(label, colour, middles, lows, highs)
