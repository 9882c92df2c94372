"""Tables of the thesis's benchmark: goal differences per episode, ours beside published numbers of GRF.

Read next: `minigames/published.csv`, the published numbers; `lab/studies/tables.py`, which puts tables onto pages.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lab.studies.cells import runs_and_steps, spell
from lab.studies.measuring import TEAM
from lab.studies.rows import TRAIN, Row
from regista.experiments.run import results as estimate
from regista.experiments.run.report import as_markdown
from regista.minigames.published import Published, find_published
from ued.statistics import Interval, rank_correlation

SPLITS = (TRAIN, "test")
RANDOM = "random"
COMPARED = {  # policies compared with published numbers in the second table: agent, split
    "one agent, training scenes": ("ppo", TRAIN),
    "one agent, test scenes": ("ppo", "test"),
    "teams, training scenes": (f"{TEAM}ppo", TRAIN),
    "random policies, test scenes": (RANDOM, "test"),
}
# Attacks have positive numbers and defenses negative ones, which alone causes a correlation over all games.
SIDES = {"all": ("",), "attacks": ("grf/", "offense/"), "defenses": ("defense/",)}
FEWEST = 4  # minimum number of games for a correlation


class Cell(NamedTuple):
    """A policy on the training or test scenes of a game; `published` is None without a published number."""

    ours: Interval
    published: Published | None


def of_one_agent(rows: Sequence[Row]) -> str:
    """Return the table of single agents, and a table that compares all policies with published numbers."""
    single = goals_table([row for row in rows if not row.agent.startswith(TEAM)])
    parts = [as_markdown(single)]
    said = [
        [name, side, *text]
        for name, (agent, split) in COMPARED.items()
        for side, starts in SIDES.items()
        if (text := agreement([row for row in rows if row.game.startswith(starts)], agent, split))
    ]
    if said:
        about = (
            "Beside published numbers, by games that have both. *Rank correlation* is Spearman's; *apart* counts games "
            "where the difference exceeds both half intervals, added as squares. 95% intervals: bootstrap over games."
        )
        head = ["policies", "games", "number", "rank correlation", "mean absolute difference", "apart"]
        parts.append(f"{about}\n\n{as_markdown([head, *said])}")
    return "\n\n".join(parts)


def of_teams(rows: Sequence[Row]) -> str:
    """Return the table of teams."""
    controls = {row.control for row in rows if row.agent.startswith(TEAM)}
    mine = [row for row in rows if row.agent.startswith(TEAM) or (row.agent == RANDOM and row.control in controls)]
    return as_markdown(goals_table(mine))


def goals_table(rows: Sequence[Row]) -> list[list[str]]:
    """Return a row for each game, set of moved players and method; the random policy is a column."""
    table = [["game", "moved", "method", TRAIN, "published", RANDOM, "test", "published", RANDOM, "runs", "env steps"]]
    for key in sorted({(row.game, row.control, row.agent) for row in rows if row.agent != RANDOM}):
        cells = []
        for split in SPLITS:
            found, uniform = cell(rows, *key, split), cell(rows, *key[:2], RANDOM, split)
            cells += [
                "" if found is None else spell(found.ours, "{:+z.2f}"),
                "" if found is None or found.published is None else told(found.published),
                "" if uniform is None else f"{uniform.ours.estimate:+z.2f}",
            ]
        mine = [row for row in rows if (row.game, row.control, row.agent) == key]
        table.append([*key, *cells, *runs_and_steps(mine)])
    return table


def cell(rows: Sequence[Row], game: str, control: str, agent: str, split: str) -> Cell | None:
    """Return the estimate of a policy and the published number; None if the policy was not played on these scenes."""
    key = (game, control, agent, split)
    found = [row.result() for row in rows if (row.game, row.control, row.agent, row.scene) == key]
    if not found:
        return None
    moved = control if agent == RANDOM or agent.startswith(TEAM) else ""  # names of moved players differ by program
    return Cell(estimate.mean_return(found), find_published(game, agent, split, moved))


def agreement(rows: Sequence[Row], agent: str, split: str) -> list[str]:
    """Return the cells that compare a policy with published numbers over games; empty below `FEWEST` games."""
    keys = sorted({(row.game, row.control) for row in rows if row.agent == agent})
    cells = [found for game, control in keys if (found := cell(rows, game, control, agent, split)) is not None]
    pairs = [(mine.ours, mine.published) for mine in cells if mine.published is not None]
    if len(pairs) < FEWEST:
        return []
    ours, theirs = [mine.estimate for mine, _ in pairs], [known.goal_difference for _, known in pairs]
    apart = [
        abs(mine.estimate - known.goal_difference) > np.hypot((mine.high - mine.low) / 2, known.interval)
        for mine, known in pairs
        if mine.known and known.interval is not None
    ]
    difference = float(np.mean(np.abs(np.subtract(ours, theirs))))
    return [
        str(len(pairs)),
        spell(rank_correlation(ours, theirs), "{:.2f}"),
        f"{difference:.2f}",
        f"{sum(apart)} of {len(apart)}" if apart else "",
    ]


def told(known: Published) -> str:
    """Return a published number with half of its interval, if the interval is known."""
    return f"{known.goal_difference:+z.2f}" + ("" if known.interval is None else f" ± {known.interval:.2f}")
