"""The page of the benchmark: tables and bar charts, ours beside the published, drawn from the CSV files alone.

Read next: `studies.rows`, what is in the files; `pictures.bars`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from regista.experiments.pictures.bars import Bars, draw_bars
from regista.experiments.run.progress import count
from regista.experiments.run.report import as_markdown, write_text
from regista.experiments.run.results import advantage, mean_return
from regista.experiments.studies.measuring import TEAM
from regista.experiments.studies.rows import TRAIN, Row, check_present, load, played_on
from regista.minigames.published import Published, find_published, published
from regista.minigames.suites import BENCHMARK
from ued.statistics import Interval, spearman

FILES = "{preset}.csv"
PRESETS = {"fast": "features, an MLP 64 wide", "thesis": "stacked SMM, the network of Fig. 4.10, Table 4.2"}
OURS, THEIRS, TEST_OURS, TEST_THEIRS = "#2b6cb0", "#a9c4e4", "#d08a1d", "#f0d3a0"
OUT_OF_PLACE = 3  # games named beneath a rank correlation
OTHER_TESTS = (
    "The published test of defense/3vs3_cross_from_side is that of the side buildup; in that of "
    "offense/avoid_pass_shoot back and mate stood in no common line."
)
INTERVALS = (
    "95% intervals: bootstrap over runs and their episodes; of one run Student's t over its episodes alone; "
    "none below 5 runs, or 5 episodes"
)

OTHERS = re.compile(r"^## [^\n]*\n(?:(?!^## ).)*?<!-- table: \w+ -->.*?<!-- end -->$", re.M | re.S)  # sections

FIGURE_2_7 = tuple(row.game for row in published() if row.source == "Fig. 2.7")
TABLE_4_1 = tuple(row.game for row in published() if row.agent == "light_cnn")
# The games of each study, and whom agents move there.
PAIRS: dict[str, tuple[tuple[str, str], ...]] = {
    "single": tuple((game, BENCHMARK[game].control) for game in FIGURE_2_7),
    "generalisation": tuple((game.name, game.control) for game in BENCHMARK.values()),
    "multi": tuple((row.game, row.control) for row in published() if row.source == "Table 3.1"),
    "teams": (  # an attack that the thesis's teams do not learn, one that they do, and a defence
        ("offense/hard_crossing", "allNonGK"),
        ("grf/pass_and_shoot_with_keeper", "allNonGK"),
        ("defense/2vs2", "all"),
    ),
    "demonstrations": tuple((row.game, row.control) for row in published() if row.agent.endswith("pretrained")),
}


class Measured(NamedTuple):
    """The rows of one preset."""

    preset: str
    rows: Sequence[Row]

    def of(self, game: str, agent: str, scene: str, control: str = "") -> list[Row]:
        """Return the rows of an agent on a scene, one for each seed; of uniform keys those of one agent.

        `control` is whom a team moves.
        """
        control = control or (BENCHMARK[game].control if agent in ("ppo", "random") and game in BENCHMARK else "")
        rows = (row for row in self.rows if (row.game, row.agent, row.scene) == (game, agent, scene))
        return [row for row in rows if control in ("", row.control)]

    def estimate(self, game: str, agent: str = "ppo", scene: str = TRAIN, control: str = "") -> Interval | None:
        """Estimate the goal difference of an agent on a scene, None where it was not measured."""
        rows = self.of(game, agent, scene, control)
        return mean_return([row.result() for row in rows]) if rows else None


def write_page(results: Path, page: Path, pictures: Path) -> None:
    """Write the page and its pictures from all files of a folder. Raises `CommandError` if the disk refuses.

    Sections of the page whose table is marked as made by others are kept, at its end.
    """
    pictures.mkdir(parents=True, exist_ok=True)
    parts = [HEAD]
    for preset in PRESETS:
        rows = read(results, preset)
        if rows:
            measured = Measured(preset, rows)
            parts += [f"## Preset `{preset}`: {PRESETS[preset]}", about(measured)]
            parts += [section(measured, page.parent, pictures) for section in SECTIONS]
    parts += OTHERS.findall(page.read_text()) if page.exists() else []
    write_text(page, _paragraphs(parts) + "\n")


def read(results: Path, preset: str) -> list[Row]:
    """Return what was measured with a preset. Raises `CommandError` for rows of another version of the simulator."""
    path = results / FILES.format(preset=preset)
    rows = load(path)
    check_present(path, rows)
    return rows


def _paragraphs(parts: Sequence[str]) -> str:
    return "\n\n".join(part for part in parts if part)


HEAD = """\
# The benchmark of the thesis, made again

Goal differences per episode, of agents in our simulator beside what is published of Google Research Football. This page
is drawn by `regista study` from small tables; what is missing in them it makes, and what is there it leaves:

```sh
regista study single --seeds 5 --hours 3           # the 13 games of Figure 2.7; after three hours call it again
regista study generalisation --seeds 3 --hours 3   # all 22, and the tests of 20
regista study multi --seeds 3                      # teams, one policy per agent: the 15 rows of Table 3.1
regista study teams --seeds 3                      # independent policies, parameter sharing, MAPPO: three rows
regista study demonstrations --seeds 3             # semi-experts, their clones, and training on from these
regista study single --preset thesis               # stacked SMM and the thesis's network
```"""


def about(measured: Measured) -> str:
    """Return what was run, on which commits, and how long it took."""
    runs = {(row.game, row.control, row.seed): row for row in measured.rows if row.env_steps}.values()
    games, seeds = {row.game for row in runs}, {row.seed for row in runs}
    steps = sorted({row.env_steps for row in runs})
    length = " to ".join(dict.fromkeys(count(step) for step in (steps[0], steps[-1]))) if steps else "no"
    spent = sum(row.seconds for row in runs) / 3600
    commits = ", ".join(sorted({row.commit for row in measured.rows} - {""}))
    return (
        f"{len(runs)} runs of {len(games)} games, {len(seeds)} seed{'s' * (len(seeds) != 1)}, {length} steps each, "
        f"paid for goals alone; {spent:.1f} hours of training in all. Measured on {played_on(measured.rows)}, "
        f"commit {commits or 'unknown'}. {INTERVALS}."
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
    picture = f"![PPO on the training scenes]({path.relative_to(folder)})"
    parts = ["### One agent (Figure 2.7)", picture, as_markdown([head, *rows])]
    return _paragraphs([*parts, ranks(measured, games, "train")])


def generalisation(measured: Measured, folder: Path, pictures: Path) -> str:
    """Return the section of Figure 2.8: training scenes beside test scenes."""
    every = [game for game in BENCHMARK if measured.of(game, "ppo", TRAIN)]
    games = [game for game in every if measured.of(game, "ppo", "test")]  # two have no test program
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
    rows = [_tested_row(measured, game) for game in every]
    picture = f"![Training and test scenes]({path.relative_to(folder)})"
    parts = ["### From training to test scenes (Figure 2.8)", picture, as_markdown([head, *rows])]
    return _paragraphs([*parts, OTHER_TESTS, *(ranks(measured, games, split) for split in (TRAIN, "test"))])


def teams(measured: Measured, folder: Path, pictures: Path) -> str:
    """Return the section of Figure 3.1 and Table 3.1: teams, ours beside the published."""
    pairs = [pair for pair in PAIRS["multi"] if measured.of(pair[0], "team_ppo", TRAIN, pair[1])]
    if not pairs:
        return ""
    path = pictures / f"benchmark_multi_{measured.preset}.png"
    names = [f"{game} ({control})" for game, control in pairs]
    ours = [measured.estimate(game, "team_ppo", TRAIN, control) for game, control in pairs]
    theirs = [find_published(game, "team_ppo", control=control) for game, control in pairs]
    draw_bars(
        names,
        [_bars("ours", OURS, ours), _published_bars("published", THEIRS, theirs)],
        "Teams on the training scenes (thesis, Figure 3.1)",
        path,
    )
    head = ["game", "moved", "uniform keys", "team", "runs", "published", "semi-expert", "published"]
    rows = [_team_row(measured, *pair) for pair in pairs]
    parts = ["### Teams (Figure 3.1, Table 3.1)", f"![Teams]({path.relative_to(folder)})", as_markdown([head, *rows])]
    return _paragraphs([*parts, correlation(dict(zip(names, zip(ours, theirs, strict=True), strict=True)))])


def sharing(measured: Measured, folder: Path, pictures: Path) -> str:
    """Return the section of teams with shared parameters or a centralised critic, beside those of the thesis."""
    rows = [row for row in measured.rows if row.agent.removeprefix(TEAM) in SHARING and row.agent.startswith(TEAM)]
    pairs = dict.fromkeys((row.game, row.control) for row in rows if row.agent != f"{TEAM}ppo")
    if not pairs:
        return ""
    agents = {row.agent for row in rows}
    titles = {f"{TEAM}{kind}": title for kind, title in SHARING.items() if f"{TEAM}{kind}" in agents}
    head = ["game", "moved", *(word for title in titles.values() for word in (title, "runs"))]
    cells = [[*pair, *(cell for agent in titles for cell in _trained(measured, agent, *pair))] for pair in pairs]
    return "\n\n".join(["### Parameter sharing, and a centralised critic", as_markdown([head, *cells])])


SHARING = {
    "ppo": "independent policies and critics",
    "shared_ppo": "shared policy and critic (parameter sharing)",
    "mappo": "independent policies, centralised critic",
    "shared_mappo": "shared policy, centralised critic (MAPPO)",
}


def demonstrations(measured: Measured, folder: Path, pictures: Path) -> str:
    """Return the section of Figure 2.10 and Table 3.2: semi-experts, their clones, and what training adds to these."""
    pairs = [pair for pair in PAIRS["demonstrations"] if _with_demonstrations(measured, *pair, "pretrained")]
    if not pairs:
        return ""
    path = pictures / f"benchmark_demonstrations_{measured.preset}.png"
    bars, cells = [], {pair: [] for pair in pairs}  # type: ignore[var-annotated]
    for agent, (label, colour, light) in DEMONSTRATED.items():
        ours = [_with_demonstrations(measured, *pair, agent) for pair in pairs]
        theirs = [_published_with(*pair, agent) for pair in pairs]
        bars += [_bars(label, colour, ours), _published_bars(f"{label}, published", light, theirs)]
        for pair, mine, told in zip(pairs, ours, theirs, strict=True):
            cells[pair] += [_cell(mine), _plain(told)]
    for game, control in pairs:
        before, after = (
            measured.of(game, _named(game, control, agent), TRAIN, control) for agent in ("ppo", "pretrained")
        )
        gain = advantage(*([row.result() for row in rows] for rows in (after, before))) if before and after else None
        cells[game, control].append(_cell(gain))
    draw_bars(
        [f"{game} ({control})" for game, control in pairs], bars, "With demonstrations (thesis, Figure 2.10)", path
    )
    labels = [label for label, *_ in DEMONSTRATED.values()]
    head = ["game", "moved", *(word for label in labels for word in (label, "published")), "gain of pretraining"]
    rows = [[game, control, *cells[game, control]] for game, control in pairs]
    parts = ["### With demonstrations (Figure 2.10, Table 3.2)", f"![With demonstrations]({path.relative_to(folder)})"]
    return "\n\n".join([*parts, as_markdown([head, *rows]), _budgets(measured, pairs)])


DEMONSTRATED = {  # label, colours of ours and of the published
    "expert": ("semi-expert", "#6b7280", "#d1d5db"),
    "ppo": ("PPO", OURS, THEIRS),
    "cloned": ("cloned", "#2f855a", "#b2dfc4"),
    "pretrained": ("cloned, then PPO", TEST_OURS, TEST_THEIRS),
}


def _budgets(measured: Measured, pairs: Sequence[tuple[str, str]]) -> str:
    """Return after how many steps those were played who have learned by playing: gains are fair where all are equal."""
    said = []
    for agent in ("ppo", "pretrained"):
        rows = [row for pair in pairs for row in measured.of(pair[0], _named(*pair, agent), TRAIN, pair[1])]
        steps = dict.fromkeys(count(row.env_steps) for row in sorted(rows, key=lambda row: row.env_steps))
        if steps:
            said.append(f"{DEMONSTRATED[agent][0]} after {' or '.join(steps)} steps")
    return f"Measured: {'; '.join(said)}."


def _named(game: str, control: str, agent: str) -> str:
    return agent if control == BENCHMARK[game].control else TEAM + agent


def _with_demonstrations(measured: Measured, game: str, control: str, agent: str) -> Interval | None:
    moved = "" if agent == "expert" else control  # a program moves whom it says
    return measured.estimate(game, _named(game, control, agent), TRAIN, moved)


def _published_with(game: str, control: str, agent: str) -> Published | None:
    named = _named(game, control, agent)
    return find_published(game, "ppo_before" if named == "ppo" else named, control=control)


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
SECTIONS: tuple[Section, ...] = (single, generalisation, teams, sharing, demonstrations, networks)


def ranks(measured: Measured, games: Sequence[str], split: str) -> str:
    """Return the rank correlation of one agent's goal differences with the published over the games."""
    pairs = {game: (measured.estimate(game, scene=split), find_published(game, "ppo", split)) for game in games}
    return correlation(pairs, f"{split} scenes of ")


def correlation(pairs: Mapping[str, tuple[Interval | None, Published | None]], scenes: str = "") -> str:
    """Return Spearman's rank correlation of ours with the published, and who is most out of place, as a sentence.

    Nothing where fewer than three are known of both.
    """
    known = {name: (one.estimate, other.goal_difference) for name, (one, other) in pairs.items() if one and other}
    if len(known) < 3:
        return ""
    mine, theirs = zip(*known.values(), strict=True)
    gap = {name: _place(mine, one) - _place(theirs, other) for name, (one, other) in known.items()}
    worst = sorted(gap, key=lambda name: -abs(gap[name]))[:OUT_OF_PLACE]
    moved = ", ".join(f"{name} ({gap[name]:+g} places)" for name in worst if gap[name])
    about = f" Most out of place, a plus where ours is easier: {moved}." if moved else ""
    value = spearman(mine, theirs)
    return f"Spearman's rank correlation with the published over {scenes}{len(known)} games: {value:.2f}.{about}"


def _place(values: Sequence[float], value: float) -> float:
    """Return how many values are below one, an equal one counting one half."""
    return sum(0.5 * (other == value) + (other < value) for other in values)


# ---------------------------------------------------------------- rows and bars


def _single_row(measured: Measured, game: str) -> list[str]:
    runs = _runs(measured.of(game, "ppo", TRAIN))
    told = [_cell(measured.estimate(game, "random")), _cell(measured.estimate(game)), runs]
    experts = [_cell(measured.estimate(game, "expert")), _plain(find_published(game, "expert"))]
    return [game, *told, _plain(find_published(game, "ppo")), *experts]


def _tested_row(measured: Measured, game: str) -> list[str]:
    ours = [_cell(measured.estimate(game, scene=scene)) for scene in (TRAIN, "test")]
    theirs = [_plain(find_published(game, "ppo", split)) for split in ("train", "test")]
    keys = [_cell(measured.estimate(game, "random", "test")), _plain(find_published(game, "random", "test"))]
    return [game, *ours, *theirs, *keys]


def _team_row(measured: Measured, game: str, control: str) -> list[str]:
    told = [_cell(measured.estimate(game, "random", TRAIN, control)), *_trained(measured, "team_ppo", game, control)]
    theirs = _plain(find_published(game, "team_ppo", control=control))
    experts = [
        _cell(measured.estimate(game, "team_expert")),
        _plain(find_published(game, "team_expert", "train", control)),
    ]
    return [game, control, *told, theirs, *experts]


def _trained(measured: Measured, agent: str, game: str, control: str) -> list[str]:
    """Return what an agent reaches on training scenes, and in how many runs."""
    return [_cell(measured.estimate(game, agent, TRAIN, control)), _runs(measured.of(game, agent, TRAIN, control))]


def _runs(rows: Sequence[Row]) -> str:
    """Return how many runs there are, and after how many steps they were played; nothing of none."""
    if not rows:
        return ""
    steps = dict.fromkeys(count(row.env_steps) for row in sorted(rows, key=lambda row: row.env_steps))
    return f"{len(rows)} × {' to '.join(steps)}"


def _cell(interval: Interval | None) -> str:
    if interval is None:
        return ""
    known = interval.known
    return f"{interval.estimate:+.2f}" + (f" [{interval.low:+.2f}, {interval.high:+.2f}]" if known else "")


def _plain(row: Published | None) -> str:
    if row is None:
        return ""
    return f"{row.goal_difference:+.2f}" + ("" if row.interval is None else f" ± {row.interval:.2f}")


def _ours(measured: Measured, games: Sequence[str], scene: str, colour: str, label: str) -> Bars:
    return _bars(label, colour, [measured.estimate(game, scene=scene) for game in games])


def _theirs(games: Sequence[str], split: str, colour: str, label: str) -> Bars:
    return _published_bars(label, colour, [find_published(game, "ppo", split) for game in games])


def _bars(label: str, colour: str, intervals: Sequence[Interval | None]) -> Bars:
    nothing = Interval(float("nan"), float("nan"), float("nan"))
    return Bars(label, colour, *zip(*(interval or nothing for interval in intervals), strict=True))


def _published_bars(label: str, colour: str, published: Sequence[Published | None]) -> Bars:
    nan = float("nan")
    middles = [nan if row is None else row.goal_difference for row in published]
    halves = [nan if row is None or row.interval is None else row.interval for row in published]
    lows, highs = ([middle + side * half for middle, half in zip(middles, halves, strict=True)] for side in (-1, 1))
    return Bars(label, colour, middles, lows, highs)
