"""Measurements in both engines at once, family by family: `python -m lab.benchmarks --suite grf --measure`.

    academy         goals of scripted policies on jittered academy scenes; its rows are those of data/academy.csv
    differential    drawn scenes with drawn actions, and the distances between the engines
    experts         goal rates of semi-expert programs, beside the published rates
    goals           where the goals of trained runs come from
    players         goals of scripted players in whole matches; its rows are those of data/players.csv

Read next: the module of a family.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lab.grf.report import render_rows
from regista.experiments.run.arguments import group
from regista.experiments.run.config import EngineConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.progress import Progress
from regista.experiments.run.results import align
from regista.experiments.transfer.goals import FAR, OUT, shares
from ued.config import LARGEST_SEED, Checked, setting


@dataclass(frozen=True)
class MeasureConfig(Checked):
    """Arguments of `python -m lab.benchmarks --suite grf --measure`."""

    measure: bool = setting(False, "measure in both engines instead; the real one must be there")
    seed: int = setting(0, "of the drawn scenes", ">=0", most=LARGEST_SEED)
    scenes: tuple[str, ...] = setting((), "drawn scenes by name, such as 0:17; none given: 200 of the seed")
    runs: tuple[Path, ...] = setting((), "run folders, of family goals")
    playing: EngineConfig = group(EngineConfig, "engine beside ours for --measure; without, grf")


Measured = tuple[str, Any]  # for a terminal, and in a form that JSON supports


def academy(config: MeasureConfig, effort: float, figures: Path | None) -> Measured:
    """Play scripted policies on jittered academy scenes in both engines; report their goals."""
    from lab.grf import academy as scenes

    other = config.playing.instead_of(replace(scenes.OURS, engine="grf"))
    progress = Progress(len(scenes.ROWS), stream=sys.stderr)
    rows = scenes.measure_both(other, max(round(scenes.GRF_EPISODES * effort), 1), progress.show)
    return align(scenes.table(rows)), {"academy": rows}


def differential(config: MeasureConfig, effort: float, figures: Path | None) -> Measured:
    """Play drawn scenes in both engines; report their distances, and the worst scenes by name."""
    from lab.grf import differential as drawn
    from lab.grf.drawn_scenes import draw_scene

    count = max(round(drawn.SCENES * effort), 1)
    names = config.scenes or tuple(f"{config.seed}:{number}" for number in range(count))
    other = config.playing.instead_of(replace(drawn.OURS, engine="grf"))
    progress = Progress(len(names), stream=sys.stderr)
    try:
        scenes = [draw_scene(name) for name in names]
    except ValueError as error:
        raise UsageError(f"--scenes: {error}") from error
    pairs = list(drawn.play_scenes(scenes, other, told=progress.show))
    rows = drawn.compare(pairs)
    if figures is not None:
        drawn.show(figures, pairs)
    tables = [drawn.energy_table(pairs), drawn.worst_table(pairs)]
    text = "\n\n".join([render_rows(drawn.TITLE, rows, drawn.REQUIRED), *map(align, tables)])
    told = {"differential": [asdict(row) | {"ok": row.ok} for row in rows], "scenes": drawn.as_json(pairs)}
    return text, told | {"energy": drawn.energies(pairs)}


def experts(config: MeasureConfig, effort: float, figures: Path | None) -> Measured:
    """Play the semi-expert programs in both engines; report their goal rates, and the rank correlation."""
    from lab.grf import experts as programs

    chosen = programs.experts()
    other = config.playing.instead_of(replace(programs.OURS, engine="grf"))
    progress = Progress(len(chosen), stream=sys.stderr)
    count = max(round(programs.EPISODES * effort), 1)
    experts = list(programs.play_experts(chosen, other, count, progress.show))
    ranks = programs.correlations(experts)
    lines = [f"rank correlation of {pair}: {value:.2f}" for pair, value in ranks.items()]
    text = "\n".join([align(programs.table(experts)), *lines])
    return text, {"experts": [expert.numbers() for expert in experts], "rank_correlations": ranks}


def goals(config: MeasureConfig, effort: float, figures: Path | None) -> Measured:
    """Play trained runs in both engines; report where their goals come from."""
    from regista.experiments.transfer.replaying import EPISODES, Plan, play_run

    if not config.runs:
        raise UsageError("family goals needs --runs: run folders, such as runs/academy/3_vs_1_with_keeper-dr-0")
    ours, grf = (max(round(count * effort), 1) for count in EPISODES)
    plan = Plan(config.playing, (ours, grf), policies=("sampled",))
    results = []
    for number, run in enumerate([RunFolder.open(path) for path in config.runs]):
        print(f"{run.path}, {number + 1} of {len(config.runs)}", file=sys.stderr, flush=True)
        results += play_run(run, plan)[0]
    rows = [
        ([result.run, result.policy, engine], numbers["goals_from"])
        for result in results
        for engine, numbers in result.engines.items()
    ]
    return align(goals_table(rows)), {"goals": [asdict(result) for result in results]}


def goals_table(rows: Sequence[tuple[list[str], dict[str, Any]]]) -> list[list[str]]:
    """Return summaries of goals, each after three cells: the run, the way of playing, and the engine."""
    far, out = ([*shares(np.zeros(1), limits)] for limits in (FAR, OUT))
    head = ["goals of", "policy", "engine", "goals", "from, m", *(f"{word} m" for word in far)]
    lines = [[*head, "keeper off his line, m", *(f"{word} m" for word in out)]]
    for first, goals in rows:
        cells = [str(goals["goals"])]
        for median, parts, words in (("distance", "distance", far), ("keeper_out", "keeper", out)):
            middle = goals.get(f"median_{median}")
            there = goals[f"{parts}_shares"] if middle is not None else {}
            cells += ["–" if middle is None else f"{middle:.1f}"]
            cells += [f"{there[word]:.0%}" if there else "–" for word in words]
        lines.append([*first, *cells])
    return lines


def players(config: MeasureConfig, effort: float, figures: Path | None) -> Measured:
    """Play whole matches of scripted players in both engines; report the goals of both teams."""
    from lab.grf import players as scripted

    other = config.playing.instead_of(replace(scripted.OURS, engine="grf"))
    progress = Progress(len(scripted.PLAYERS) * len(scripted.DIFFICULTIES), stream=sys.stderr)
    rows = scripted.measure_both(other, max(round(scripted.GRF_MATCHES * effort), 1), progress.show)
    return align(scripted.table(rows)), {"players": rows}


MEASURES: dict[str, Callable[[MeasureConfig, float, Path | None], Measured]] = {
    "academy": academy,
    "differential": differential,
    "experts": experts,
    "goals": goals,
    "players": players,
}
