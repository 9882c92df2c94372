"""Tables of chapter 4: returns by scene with differences to DR, the four strategies, and Table 4.1 beside the thesis.

Read next: `regista.experiments.run.report`, which makes the first ones and marks their differences.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from lab.studies.cells import percent, spell
from lab.studies.rows import TRAIN, Row, played_on
from lab.studies.runs import ROOT
from lab.studies.tables import NOTE
from lab.thesis.plan import FIGURES, in_order
from regista.experiments.run import results as estimate
from regista.experiments.run import significance
from regista.experiments.run.errors import CommandError
from regista.experiments.run.progress import count
from regista.experiments.run.report import INTERVALS, Report, as_markdown, write_text
from regista.experiments.run.results import unique
from regista.minigames.published import find_published

PAGE = ROOT / "docs" / "benchmarks" / "thesis.md"
THEIRS = ("light_cnn", "impala_cnn")  # of Table 4.1: the thesis's network, and GRF's network


def paired_tables(rows: Sequence[Row]) -> str:
    """Return a table for each game: mean returns of each method on each scene, and differences to DR with marks."""
    parts = []
    for game, figure in FIGURES.items():
        mine = in_order([row for row in rows if row.game == game])
        if not mine:
            continue
        report = Report([row.result() for row in mine])
        table = [line[:-1] for line in report.by_scene() if line[1] != report.word]  # without goals and updates
        notes = significance.sentences(*report.notes_by_scene()[1:])
        parts.append(f"**Figure {figure.number}: {figure.title}**\n\n{as_markdown(table)}\n\n{notes}".rstrip())
    about = f"Mean returns per episode; {per_run(rows)}. {INTERVALS}."
    return "\n\n".join([*parts, f"{about} {made(rows, 'paired')}"])


def strategies_table(rows: Sequence[Row]) -> str:
    """Return the goal differences of the built-in AI against each strategy (Figure 4.4)."""
    table = [["strategy of the defender", "goal difference of the built-in AI", "episodes with a goal"]]
    for row in rows:
        mine = [row.result()]
        goals = spell(estimate.mean_return(mine), "{:+z.2f}")
        table.append([row.scene, goals, percent(estimate.goal_rate(mine))])
    about = f"{per_run(rows)}; 95% intervals over episodes: Student's t, Wilson's for shares."
    return f"{as_markdown(table)}\n\n{about[0].upper()}{about[1:]} {made(rows, 'strategies')}"


def randomization_table(rows: Sequence[Row]) -> str:
    """Return Table 4.1: mean returns of DR on each training distribution, ours and published."""
    table = [["game", "DR, ours", "thesis", "GRF's network, by the thesis", "env steps", "runs"]]
    for game in unique([row.game for row in rows]):
        mine = [row.result() for row in rows if row.game == game and row.scene == TRAIN]
        known = [find_published(game, agent) for agent in THEIRS]
        cells = ["" if one is None else f"{one.goal_difference:+z.2f}" for one in known]
        steps = " to ".join(unique([count(row.env_steps) for row in mine]))
        table.append([game, spell(estimate.mean_return(mine), "{:+z.2f}"), *cells, steps, str(len(mine))])
    about = f"Mean returns per episode on random levels; {per_run(rows)}. {NOTE}."
    return f"{as_markdown(table)}\n\n{about} {made(rows, 'randomization')}"


def per_run(rows: Sequence[Row]) -> str:
    """Return the number of episodes of each policy on each scene, in words."""
    return f"{' or '.join(unique([str(row.episodes) for row in rows]))} episodes of each policy on each scene"


def made(rows: Sequence[Row], command: str) -> str:
    """Return the simulators on which rows were measured, and the command, in words."""
    return f"Measured on {played_on(rows)}; `python -m lab.thesis {command}`."


def publish(name: str, text: str, page: Path = PAGE) -> None:
    """Put a text between its marks on a page. Raises `CommandError` if the page has no such marks."""
    old = page.read_text()
    found = re.search(f"(<!-- thesis: {name} -->\n).*?(<!-- end -->)", old, re.S)
    if found is None:
        raise CommandError(f"{page} has no place '<!-- thesis: {name} -->' ... '<!-- end -->'")
    write_text(page, f"{old[: found.start()]}{found[1]}{text}\n{found[2]}{old[found.end() :]}")
