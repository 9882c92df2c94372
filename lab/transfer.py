"""What transfers to Google Research Football (GRF)? Trains and plays in both engines, one part at a time.

Each part writes lab/results/transfer_PART.csv and can be stopped at any time; the same command continues it. Rows of
another simulator version are dropped, and runs are trained again. `make grf` installs GRF. The numbers below are
core-minutes; two processes use two per minute:

    python -m lab.transfer policies    # 38: nine games, two representations, five seeds
    python -m lab.transfer defense     # 22: four defenses, three seeds, 5M steps
    python -m lab.transfer scenes      # 6: 200 drawn scenes, the same actions in both engines
    python -m lab.transfer experts     # 9: nine semi-expert programs, 200 episodes in each engine
    python -m lab.transfer converse    # 95, estimated: PPO trained in GRF on two games, three seeds, 300k steps
    python -m lab.transfer tables      # seconds: all tables of TRANSFER.md and BENCHMARK.md, from the CSV files

The table of exploits uses the rows of `policies`. Read next: `lab/transfer_tables.py`, which makes the tables.
"""

from __future__ import annotations

import argparse
import csv
import os
import resource
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, wait
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, NamedTuple

from lab.grf import differential, experts
from lab.grf.drawn_scenes import draw_scene
from lab.studies.runs import StudyRuns, training
from lab.transfer_tables import RESULTS, simulator_version, write_tables
from regista.envs.grf.workers import GrfError
from regista.experiments.commands import train
from regista.experiments.run.config import EngineConfig
from regista.experiments.run.errors import CommandError
from regista.experiments.run.launch.workers import processes
from regista.experiments.run.report import save_rows
from regista.experiments.transfer.replaying import Plan, Result, play_run

BUDGETS = {  # env_steps after which returns hardly rise
    "academy/run_to_score": 500_000,
    "academy/run_to_score_with_keeper": 1_000_000,
    "academy/pass_and_shoot_with_keeper": 500_000,
    "academy/run_pass_and_shoot_with_keeper": 500_000,
    "academy/3_vs_1_with_keeper": 500_000,
    "academy/counterattack_easy": 1_000_000,
    "1v1Restricted": 1_000_000,
    "1v1Free": 1_000_000,
    "3v2FourBehaviors": 1_000_000,
}
DEFENSES = ("2vs2", "2vs2_counterattack", "2vs2_high_pass", "3vs3_cross_from_side")
DEFENSE_STEPS = 5_000_000
CONVERSE = ("academy/run_to_score", "academy/3_vs_1_with_keeper")
CONVERSE_STEPS = 300_000
SEEDS = range(400, 405)  # used for nothing else
SCENES, SCENES_SEED, CHUNK = 200, 40_401, 10
EXPERTS_SEED = 400
GRF = EngineConfig(engine="grf", grf_workers=1)  # each of our processes has one process with GRF engines


class Unit(NamedTuple):
    """Work of one process: `key` identifies it in the CSV file, by column; a trained run has settings and a budget."""

    part: str
    key: dict[str, Any]
    settings: dict[str, Any] | None = None
    rewards: str = ""
    episodes: tuple[int, int] = (0, 0)  # in our simulator and in GRF


@dataclass(frozen=True)
class Options:
    """Command line options: `env_steps` and `episodes` replace a part's own if they are not 0."""

    out: Path
    results: Path
    processes: int
    hours: float
    limit: int
    env_steps: int
    episodes: int


# ---------------------------------------------------------------- the parts


def policies() -> Iterator[Unit]:
    """Yield DR runs of nine games; jitter and spread are those of `docs/howto/real-engine.md`."""
    for seed in SEEDS:
        for representation in ("simple115", "features"):
            for game, steps in BUDGETS.items():
                settings = {"total_env_steps": steps, "env.representation": representation, "env.engine_spread": 0.15}
                if game.startswith("academy/"):
                    settings["program.param"] = ("jitter=1",)
                key = {"game": game, "representation": representation, "seed": seed}
                yield Unit("policies", key, settings, "scoring,checkpoints", (200, 50))


def defense() -> Iterator[Unit]:
    """Yield runs of four defenses, with the settings and the budget of `python -m lab.studies single`."""
    for seed in SEEDS[:3]:
        for game in DEFENSES:
            key = {"game": f"defense/{game}", "representation": "features", "seed": seed}
            yield Unit("defense", key, {"total_env_steps": DEFENSE_STEPS}, "scoring", (200, 60))


def converse() -> Iterator[Unit]:
    """Yield runs that are trained in GRF, from the academy's fixed start."""
    for seed in SEEDS[:3]:
        for game in CONVERSE:
            key = {"game": game, "representation": "simple115", "seed": seed}
            settings = {"total_env_steps": CONVERSE_STEPS, "env.representation": "simple115", "num_envs": 32}
            settings |= {"env.engine": "grf", "env.grf_workers": 1}
            yield Unit("converse", key, settings, "scoring,checkpoints", (300, 100))


def scenes() -> Iterator[Unit]:
    """Yield drawn scenes, `CHUNK` at a time."""
    for first in range(0, SCENES, CHUNK):
        yield Unit("scenes", {"seed": SCENES_SEED, "first": first})


def programs() -> Iterator[Unit]:
    """Yield the semi-expert programs."""
    for expert in experts.experts():
        yield Unit("experts", {"program": expert.name, "seed": EXPERTS_SEED}, episodes=(200, 200))


PARTS = {"policies": policies, "defense": defense, "scenes": scenes, "experts": programs, "converse": converse}


# ---------------------------------------------------------------- one unit


def do(unit: Unit, options: Options) -> list[dict[str, Any]]:
    """Do a unit's work and return its rows; the output of training goes to a file."""
    folder = options.out / simulator_version() / unit.part
    folder.mkdir(parents=True, exist_ok=True)
    began = core_seconds()
    with open(folder / "log.txt", "a") as log, redirect_stdout(log), redirect_stderr(log):
        rows = {"scenes": do_scenes, "experts": do_expert}.get(unit.part, do_run)(unit, options, folder)
    spent = round(core_seconds() - began)
    return [{"simulator": simulator_version(), **unit.key, **row, "core_seconds": spent} for row in rows]


def core_seconds() -> float:
    """Return the CPU time of this process and of its ended children, including those with GRF engines."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def do_run(unit: Unit, options: Options, folder: Path) -> list[dict[str, Any]]:
    """Train a run, or continue it, and play it in both engines; return a row for each engine."""
    settings = dict(unit.settings or {})
    if options.env_steps:
        settings["total_env_steps"] = options.env_steps
    folder /= str(settings["total_env_steps"])  # no run continues a run of another budget
    run = StudyRuns(folder, training(unit.rewards), {}).open(unit.key["game"], unit.key["seed"], settings)
    if not run.finished() and train.main(run.argv[1:]):
        raise CommandError(f"{run.path} was stopped")
    episodes = (options.episodes, options.episodes) if options.episodes else unit.episodes
    (result,), _ = play_run(run, Plan(GRF, episodes, ("sampled",)))
    return [{"env_steps": run.env_steps(), **row} for row in rows_of(result)]


def rows_of(result: Result) -> Iterator[dict[str, Any]]:
    """Yield a row for each engine: goals, returns, endings, and where goals come from, as shares of the goals."""
    for engine, numbers in result.engines.items():
        row = {"engine": engine}
        row |= {name: numbers[name] for name in ("episodes", "goals", "mean_return", "return_error", "median_length")}
        row |= {f"ended/{word}": share for word, share in numbers["endings"].items()}
        for name in ("distance", "keeper"):
            shares = numbers["goals_from"].get(f"{name}_shares", {})
            row |= {f"{name}/{word}": share for word, share in shares.items()}
        yield row


def do_scenes(unit: Unit, options: Options, folder: Path) -> list[dict[str, Any]]:
    """Play drawn scenes in both engines; return a row for each."""
    count = min(options.episodes or CHUNK, CHUNK)
    drawn = [draw_scene(f"{SCENES_SEED}:{number}") for number in range(unit.key["first"], unit.key["first"] + count)]
    kept = ("scene", "sides", "endings_agree", "ball_", "players_")
    found = []
    for pair in differential.play_scenes(drawn, GRF.instead_of(differential.OURS)):
        (numbers,) = differential.as_json([pair])
        found.append({name: value for name, value in numbers.items() if name.startswith(kept)})
    return found


def do_expert(unit: Unit, options: Options, folder: Path) -> list[dict[str, Any]]:
    """Play a program in both engines; return a row for each."""
    (expert,) = (each for each in experts.experts() if each.name == unit.key["program"])
    rows = []
    engines = {"ours": experts.OURS, "grf": GRF.instead_of(experts.OURS)}
    for (engine, config), count in zip(engines.items(), unit.episodes, strict=True):
        played = experts.play_expert(expert, config, options.episodes or count, EXPERTS_SEED)
        rows.append({"engine": engine, "episodes": len(played), "goals": int(played.scored.sum())})
    return rows


# ---------------------------------------------------------------- all units of a part


def load(path: Path) -> list[dict[str, Any]]:
    """Return the rows of a file that were measured with this simulator version."""
    if not path.exists():
        return []
    with open(path, newline="") as file:
        return [row for row in csv.DictReader(file) if row["simulator"] == simulator_version()]


def missing(units: Sequence[Unit], rows: Sequence[dict[str, Any]]) -> list[Unit]:
    """Return the units without rows."""
    done = {place(units, row) for row in rows}
    return [unit for number, unit in enumerate(units) if number not in done]


def place(units: Sequence[Unit], row: dict[str, Any]) -> int:
    """Return the index of a row's unit; the number of units for a row of another call."""
    alike = (n for n, unit in enumerate(units) if all(str(row[name]) == str(v) for name, v in unit.key.items()))
    return next(alike, len(units))


def do_all(units: Sequence[Unit], options: Options, path: Path) -> bool:
    """Do the units without rows in parallel, and save rows as they come; return whether all units have rows.

    A unit that fails is reported and left for the next call.
    """
    os.environ["OMP_NUM_THREADS"] = "1"  # of each started process
    units, rows = units[: options.limit or None], load(path)
    waiting, began = missing(units, rows), time.monotonic()
    active: dict[Any, Unit] = {}
    print(f"{path.name}: {len(units) - len(waiting)} of {len(units)} done", flush=True)
    with processes(options.processes) as pool:
        while waiting or active:
            if time.monotonic() - began > 3600 * options.hours:
                waiting = []
            while waiting and len(active) < options.processes:
                unit = waiting.pop(0)
                active[pool.submit(do, unit, options)] = unit
            for future in wait(active, return_when=FIRST_COMPLETED).done:
                unit = active.pop(future)
                words = " ".join(map(str, unit.key.values()))
                try:
                    rows += future.result()
                except (CommandError, GrfError) as error:
                    print(f"{words}: {error}", flush=True)
                    continue
                save(sorted(rows, key=lambda row: place(units, row)), path)
                print(f"{words}, {(time.monotonic() - began) / 60:.1f} minutes", flush=True)
    return not missing(units, load(path))


def save(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """Write all rows, with four digits for real numbers."""
    path.parent.mkdir(parents=True, exist_ok=True)
    plain = [
        {name: f"{v:.4g}" if isinstance(v, float) else v for name, v in row.items() if v not in ("", None)}
        for row in rows
    ]
    columns = dict.fromkeys(name for row in plain for name in row)
    save_rows([dict.fromkeys(columns, "") | row for row in plain], list(columns), path)


def options_of(parser: argparse.ArgumentParser) -> tuple[Options, dict[str, Any]]:
    """Add the options that all parts share and parse; return them, and the other arguments."""
    parser.add_argument("--out", type=Path, default=Path("runs/transfer"), help="folder of the trained runs")
    parser.add_argument("--results", type=Path, default=RESULTS, help="folder of the CSV files")
    parser.add_argument("--processes", type=int, default=2, help="units at a time")
    parser.add_argument("--hours", type=float, default=1.0, help="begin nothing after so long; call again to continue")
    parser.add_argument("--limit", type=int, default=0, help="do only so many units; 0: all")
    parser.add_argument("--env-steps", type=int, default=0, help="budget of each run; 0: the part's own")
    parser.add_argument("--episodes", type=int, default=0, help="episodes in each engine; 0: the part's own")
    typed = vars(parser.parse_args())
    options = Options(**{item.name: typed.pop(item.name) for item in fields(Options)})
    return replace(options, out=options.out.resolve()), typed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=(*PARTS, "all", "tables"))
    options, typed = options_of(parser)
    part, done = typed["part"], True
    for name in (part,) if part in PARTS else PARTS if part == "all" else ():
        done &= do_all(list(PARTS[name]()), options, options.results / f"transfer_{name}.csv")
    if options.results == RESULTS:
        write_tables()
    raise SystemExit(not done)


if __name__ == "__main__":
    main()
