"""Tables of `lab/paired_football.py`: success on held-out scenes, and how often PAIRED proposed the rare option.

Values are in percent, with 95% bootstrap intervals over whole runs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations, groupby

import numpy as np

from regista.envs.football.version import simulator_name
from regista.experiments.run import significance
from regista.experiments.run.progress import count
from regista.experiments.run.report import as_markdown
from regista.experiments.run.results import unique
from regista.experiments.run.significance import difference_of_means, points
from ued.statistics import Difference, bootstrap, detectable

FIFTHS = 5  # of a run; each has its share of the rare branch in the proposals
EPISODES = 300  # on each held-out scene
TITLE = "Rare levels, by the order of the options"  # of the section of the page
SCENES = {"scene_0": "rare scene", "scene_1": "other scene"}
LAST = f"rare_share_{FIFTHS - 1}"
SHOWN = SCENES | {"held_out": "both scenes", LAST: "rare option in proposals"}

Rows = Sequence[Mapping[str, str]]
Kind = tuple[str, str, str]  # game, order, setting


def table(rows: Rows, kinds: Sequence[Kind]) -> str:
    """Return the success of each setting with each order, and the difference to its game's first setting, in Markdown.

    A game without rows of its first setting has no differences.
    """
    runs = {kind: [row for row in rows if (row["game"], row["order"], row["variant"]) == kind] for kind in kinds}
    firsts = {game: next(kind for kind in kinds if kind[0] == game) for game, _, _ in kinds}
    runs = {kind: mine for kind, mine in runs.items() if mine}
    return compared(runs, firsts, ["game", "order", "setting"], between_orders(runs))


def between_orders(runs: Mapping[Kind, Rows]) -> str:
    """Return a sentence on the differences between orders of one setting; "" if no setting has several orders."""
    gains = {}
    for (game, setting), kinds in groupby(sorted(runs, key=by_setting), by_setting):
        for one, other in combinations([kind for kind in kinds if kind[1] != "even"], 2):
            found = difference_of_means(shares(runs[one]), shares(runs[other]))
            gains[f"`{game}`, {setting}, {one[1]} minus {other[1]}"] = found
    if not gains:
        return ""
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    name, largest = max(gains.items(), key=lambda gain: abs(gain[1].estimate))
    marked = sum(mark == significance.SURVIVES for mark in marks.values())
    return (
        f"{marked or 'none'} of the {len(gains)} differences between two orders of one setting "
        f"{'survives' if marked < 2 else 'survive'} Holm's correction; the largest is {points(largest, marks[name])} "
        f"points, of {name}"
    )


def by_setting(kind: Kind) -> tuple[str, str]:
    """Return the game and the setting, without the order."""
    return kind[0], kind[2]


def summary(rows: Rows, kinds: Sequence[Kind]) -> str:
    """Return the same table, in which each seed's mean over all orders counts as one run."""
    settings = list(dict.fromkeys((game, "", setting) for game, _, setting in kinds))
    runs = {kind: over_orders([row for row in rows if (row["game"], "", row["variant"]) == kind]) for kind in settings}
    firsts = {game: next(kind for kind in settings if kind[0] == game) for game, _, _ in settings}
    text = compared({kind: mine for kind, mine in runs.items() if mine}, firsts, ["game", "setting"])
    return f"{text} PAIRED and PLR: each seed's mean over three orders of the options counts as one run."


def over_orders(rows: Rows) -> list[Mapping[str, str]]:
    """Return a row for each seed: the means of the table's columns over its rows."""
    found: list[Mapping[str, str]] = []
    for seed in unique([row["seed"] for row in rows]):
        mine = [row for row in rows if row["seed"] == seed]
        values = {name: [float(row[name]) for row in mine if row.get(name)] for name in SHOWN}
        means = {name: str(np.mean(some)) if some else "" for name, some in values.items()}
        found.append({**mine[0], "order": "", **means})
    return found


def compared(runs: Mapping[Kind, Rows], firsts: Mapping[str, Kind], columns: Sequence[str], more: str = "") -> str:
    """Return a table of groups of runs, with differences to the first setting of each game; `more` is for its note."""
    others = [kind for kind in runs if kind != firsts[kind[0]] and firsts[kind[0]] in runs]
    gains = {kind: difference_of_means(shares(runs[kind]), shares(runs[firsts[kind[0]]])) for kind in others}
    marks = dict(zip(gains, significance.marks(list(gains.values())), strict=True))
    reference = " or ".join(dict.fromkeys(setting for _, _, setting in firsts.values()))
    told = [[*columns, "runs", *SHOWN.values(), f"minus {reference}, both scenes"]]
    for kind, mine in runs.items():
        difference = points(gains[kind], marks[kind]) if kind in gains else ""
        named = [word for word, column in zip(kind, ("game", "order", "setting"), strict=True) if column in columns]
        told.append([*named, str(len(mine)), *(cell(mine, column) for column in SHOWN), difference])
    return f"{as_markdown(told)}\n\n{below(list(runs.values()), list(gains.values()), more)}"


def below(runs: Sequence[Rows], gains: Sequence[Difference], more: str) -> str:
    """Return the note below the table: budget, marks, the smallest visible difference, `more`, simulator and command.

    The deviations of runs are pooled over all settings of a game.
    """
    rows = [row for mine in runs for row in mine]
    steps = " to ".join(unique([count(int(row["env_steps"])) for row in rows]))
    games = unique([row["game"] for row in rows])
    sizes = [100 * detectable([shares(mine) for mine in runs if mine[0]["game"] == game]) for game in games]
    said = significance.sentences(
        f"success rates in percent on {EPISODES} episodes of each scene, {steps} env steps; 95% intervals: bootstrap "
        "over runs, none below 5",
        significance.legend([found.p for found in gains]),
        significance.visible(sizes, [len(mine) for mine in runs], "{:.0f} points", "game"),
        more,
    )
    names = " and ".join(unique([simulator_name(int(row["simulator"])) for row in rows]))
    return f"{said} Measured on {names}; `python -m lab.paired_football`."


def shares(rows: Rows) -> np.ndarray:
    """Return the held-out success `[R]` of some runs, as shares."""
    return np.array([float(row["held_out"]) / 100 for row in rows])


def cell(rows: Rows, column: str) -> str:
    """Return the mean of a column in percent with its interval; empty if no run has the column."""
    scale = 100 if column.startswith("rare") else 1
    values = np.array([scale * float(row[column]) for row in rows if row.get(column)])
    if not len(values):
        return ""
    found = bootstrap(values, np.random.default_rng(0)).interval()
    low, high = np.clip((found.low, found.high), 0, 100)
    return f"{found.estimate:.0f}" + (f" [{low:.0f}, {high:.0f}]" if found.known else "")
