"""Chapter 4 of the thesis in our simulator: PAIRED beside domain randomization (DR) on its four games.

    python -m lab.thesis paired             # Figures 4.5 to 4.9: four games, five methods, ten seeds, 5M env steps
    python -m lab.thesis strategies         # Figure 4.4: the built-in AI against the four strategies of a defender
    python -m lab.thesis randomization      # Table 4.1: DR on six games of the benchmark, ten seeds
    python -m lab.thesis figures            # draw the figures and print the tables again from the stored rows

Runs, rows and figures lie beneath `--out`; a second call skips runs with rows and continues stopped ones. `--publish`
keeps the rows in lab/results, the figures in experiments/gallery and the tables in docs/benchmarks/thesis.md. Read
next: `lab/thesis/plan.py`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from lab.studies.rows import add, check_present, load
from lab.studies.runs import LONGEST, ROOT
from lab.thesis import figures, plan, study, tables
from lab.thesis.curves import Value
from regista.experiments.run.errors import UsageError, run_command

RESULTS, GALLERY = ROOT / "lab" / "results", ROOT / "experiments" / "gallery"


class Places(NamedTuple):
    """Output locations of rows and figures; `page`: whether tables also go onto the page."""

    rows: Path
    pictures: Path
    page: bool

    def table(self, name: str) -> Path:
        """Return the CSV file of rows."""
        return self.rows / f"thesis_{name}.csv"

    def figure(self, number: str) -> Path:
        """Return the file of a figure, such as 4.5."""
        self.pictures.mkdir(parents=True, exist_ok=True)
        return self.pictures / f"figure_{number.replace('.', '_')}.png"


def paired(typed: argparse.Namespace, places: Places) -> int:
    """Train and play the runs of Figures 4.5 to 4.9."""
    arms = list(plan.paired_arms(typed.games or [*plan.FIGURES], typed.methods, budget(typed)))
    return study.do(arms, places.table("paired"), places.table("curves"), options(typed))


def strategies(typed: argparse.Namespace, places: Places) -> int:
    """Play the built-in AI against the four strategies."""
    table = places.table("strategies")
    check_present(table, load(table))
    table.parent.mkdir(parents=True, exist_ok=True)
    if not load(table):
        add(table, study.measure_strategies(typed.episodes))
    return 0


def randomization(typed: argparse.Namespace, places: Places) -> int:
    """Train and play the runs of Table 4.1."""
    arms = list(plan.table_arms(typed.games or plan.table_games(), budget(typed)))
    return study.do(arms, places.table("randomization"), None, options(typed))


COMMANDS: dict[str, Callable[[argparse.Namespace, Places], int]] = {
    "paired": paired,
    "strategies": strategies,
    "randomization": randomization,
    "figures": lambda typed, places: 0,
}


def budget(typed: argparse.Namespace) -> plan.Budget:
    """Return the seeds, the preset and the steps of the runs."""
    return plan.Budget(range(typed.seeds), typed.preset, typed.env_steps)


def options(typed: argparse.Namespace) -> study.Options:
    """Return the options of a study."""
    return study.Options(typed.out / typed.command, typed.preset, typed.episodes, typed.processes, typed.hours)


def show(command: str, places: Places) -> None:
    """Draw the figures and print or publish the tables of one command, or of all with "figures", if they have rows."""
    if places.table("curves").exists() and command in ("paired", "figures"):
        figures.draw_curves(load(places.table("curves"), Value), places.figure("4.9"))
    made = {"paired": tables.paired_tables, "strategies": tables.strategies_table}
    for name, table in (made | {"randomization": tables.randomization_table}).items():
        rows = load(places.table(name))
        if not rows or command not in (name, "figures"):
            continue
        check_present(places.table(name), rows)
        if name == "strategies":
            figures.draw_strategies(rows, places.figure("4.4"))
        for game, figure in plan.FIGURES.items() if name == "paired" else ():
            mine = [row for row in rows if row.game == game]
            if mine:
                figures.draw_bars(game, mine, places.figure(figure.number))
        if places.page:
            tables.publish(name, table(rows))
        else:
            print(f"\n{table(rows)}")
    print(f"\nfigures: {places.pictures}, rows: {places.rows}")


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog="python -m lab.thesis", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("command", choices=COMMANDS)
    made.add_argument("--games", nargs="+", choices=(*plan.FIGURES, *plan.table_games()), help="some of the games")
    made.add_argument(
        "--methods", nargs="+", choices=plan.METHODS, default=[*plan.METHODS], help="some of the methods of paired"
    )
    made.add_argument("--seeds", type=int, default=len(plan.SEEDS), help="seeds 0 to N - 1 (default %(default)s)")
    made.add_argument("--env-steps", type=int, default=plan.STEPS, help="of a run (default %(default)s, or 10M)")
    made.add_argument("--episodes", type=int, default=plan.EPISODES, help="on each scene (default %(default)s)")
    made.add_argument("--preset", choices=("fast", "thesis"), default="fast", help="thesis: images, a core-day a run")
    made.add_argument("--processes", type=int, default=0, help="runs at a time; 0: one for each core")
    made.add_argument("--hours", type=float, default=LONGEST, help="stop after so long; called again, it goes on")
    made.add_argument("--out", type=Path, default=Path("runs/thesis"), help="folder of runs, rows and figures")
    made.add_argument("--publish", action="store_true", help="keep rows, figures and tables in the repository")
    return made


def check_published(typed: argparse.Namespace) -> None:
    """Refuse to publish results that deviate from the experiment; fewer seeds or games are a part of it."""
    defaults = parser().parse_args([typed.command])
    others = [name for name in ("env_steps", "episodes", "preset") if getattr(typed, name) != getattr(defaults, name)]
    others += ["seeds"] if typed.seeds > len(plan.SEEDS) else []
    if typed.publish and others:
        flags = ", ".join(f"--{name.replace('_', '-')}" for name in others)
        raise UsageError(f"with this {flags} it is not the experiment of the thesis; leave out --publish")


def main(argv: Sequence[str]) -> int:
    """Run the command; return the exit code. Raises `UsageError` for settings that must not be published."""
    typed = parser().parse_args(argv)
    if min(typed.env_steps, typed.episodes, typed.seeds) < 1 or typed.processes < 0 or typed.hours <= 0:
        raise UsageError("--env-steps, --episodes, --seeds must be 1 or more, --processes 0 or more, --hours above 0")
    check_published(typed)
    places = Places(typed.out / "results", typed.out / "figures", False)
    if typed.publish:
        places = Places(RESULTS, GALLERY, True)
    code = COMMANDS[typed.command](typed, places)
    show(typed.command, places)
    return code


if __name__ == "__main__":
    sys.exit(run_command(main, sys.argv[1:]))
