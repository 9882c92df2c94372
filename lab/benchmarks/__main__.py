"""Speed of the simulator, of training and of the language, side by side in one run.

    python -m lab.benchmarks --suite sim
    python -m lab.benchmarks --suite language
    python -m lab.benchmarks --suite scale --figures scale       # costs by environments, players, θ, buffers ...
    python -m lab.benchmarks --suite grf --family motion ball      # likeness to Google Research Football, not speed
    python -m lab.benchmarks --suite grf --measure                 # the same actions in drawn scenes, in both engines
    python -m lab.benchmarks --suite grf --measure --family experts
    python -m lab.benchmarks --json > today.json

Read next: `regista.envs.football.batch`, the loop that is measured; `benchmarks.training`.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from lab.benchmarks.behaviors import ORIGINAL, behaviors_suite
from lab.benchmarks.language import language_suite, render_language
from lab.benchmarks.observations import observation_rows
from lab.benchmarks.timing import Measurement, machine, machine_line, random_steps, rate
from lab.benchmarks.training import training_suite
from lab.grf.measure import MEASURES, MeasureConfig
from lab.grf.report import FAMILIES, compare, draw, render_family
from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import run_command
from regista.experiments.run.games import find_minigame
from regista.experiments.run.programs import load_program
from regista.experiments.run.results import align
from ued.config import Checked, setting

DESCRIPTION = "Measure env steps per second of the simulator and of training, and scenes per second of programs."

# Google Research Football, random actions, academy scenarios with 3 to 6 players, one core of an AMD EPYC. The range
# is over scenarios and observations, measured with GRF's own `create_environment(render=False)`.
REFERENCE = (310, 570)


@dataclass(frozen=True)
class BenchmarkConfig(Checked):
    """Arguments of `python -m lab.benchmarks`."""

    suite: Literal["sim", "train", "language", "all", "scale", "grf"] = setting(
        "all",
        "sim: the simulator alone; train: every method and teams; language: programs, scenes, behaviors; all of these; "
        "scale: what grows with environments, players, θ, buffers, threads, agents; "
        "grf: likeness to Google Research Football",
    )
    minigame: str = setting("1v1Free", "what is played")
    num_envs: int = setting(256, "environments of the simulator's batch", ">=1", most=100_000)
    seconds: float = setting(1.0, "about how long each measurement takes", ">0", most=86_400)
    json: bool = setting(False, "print JSON instead of a table")
    family: tuple[str, ...] = setting(
        (),
        f"of suite grf, among {', '.join(FAMILIES)}; none given: all. With --measure among {', '.join(MEASURES)}; "
        "none given: differential",
    )
    figures: Path | None = setting(None, "folder for pictures: of suite scale one, of suite grf one per family")
    effort: float = setting(1.0, "of suite grf: repetitions, as a share of the usual", ">0", most=1_000)
    measuring: MeasureConfig = group(MeasureConfig, "both engines at once, of suite grf")

    def __post_init__(self) -> None:
        super().__post_init__()
        known = tuple(MEASURES) if self.measuring.measure else FAMILIES
        for name in self.family:
            if name not in known:
                raise ValueError(f"--family: no '{name}', only {', '.join(known)}")


def main(argv: Sequence[str]) -> int:
    """Run the suites and return the exit code; a user error is reported in one sentence."""
    return run_command(measure_all, argv)


def measure_all(argv: Sequence[str]) -> int:
    """Run the suites and return the exit code."""
    config = arguments.parse(BenchmarkConfig(), argv, "python -m lab.benchmarks", DESCRIPTION)
    if config.suite == "grf":
        return measure(config) if config.measuring.measure else likeness(config)
    find_minigame(config.minigame)
    if config.suite == "scale":
        return scale(config)
    suites: dict[str, Sequence[Any]] = {}
    if config.suite in ("sim", "all"):
        suites["simulator"] = simulator_suite(config)
    if config.suite in ("train", "all"):
        suites["training"] = training_suite(config.minigame, config.seconds)
    if config.suite in ("language", "all"):
        suites["language"] = language_suite(config.seconds)
        suites["behaviors"] = behaviors_suite(config.seconds)
    if config.json:
        results = {suite: [row._asdict() for row in rows] for suite, rows in suites.items()}
        print(json.dumps({"machine": machine(), "reference": REFERENCE, "results": results}, indent=2))
    else:
        print("\n\n".join([machine_line(), *(render(suite, rows) for suite, rows in suites.items())]))
    return 0


def likeness(config: BenchmarkConfig) -> int:
    """Compare our simulator with the measurements of GRF, family by family, and print each result as it arrives."""
    results = {}
    for family in config.family or FAMILIES:
        rows = compare(family, config.effort)
        results[family] = [asdict(row) | {"ok": row.ok} for row in rows]
        if config.figures is not None:
            draw(family, config.figures, config.effort)
        if not config.json:
            print(render_family(family, rows), end="\n\n", flush=True)
    if config.json:
        print(json.dumps({"machine": machine(), "results": results}, indent=2))
    return 0


def measure(config: BenchmarkConfig) -> int:
    """Measure both engines, family by family, and print each result as it arrives."""
    results: dict[str, Any] = {}
    for family in config.family or ("differential",):
        text, numbers = MEASURES[family](config.measuring, config.effort, config.figures)
        results |= numbers
        if not config.json:
            print(text, end="\n\n", flush=True)
    if config.json:
        print(json.dumps({"machine": machine(), "results": results}, indent=2))
    return 0


def scale(config: BenchmarkConfig) -> int:
    """Measure how costs grow, and draw the curves if figures are requested."""
    from lab.benchmarks.scale import draw, rows_of, scale_suite

    points = list(scale_suite(config.minigame, config.seconds))
    if config.figures is not None:
        path = draw(points, config.figures)
    if config.json:
        print(json.dumps({"machine": machine(), "results": [point._asdict() for point in points]}, indent=2))
    else:
        print(f"{machine_line()}\n\n{align(rows_of(points))}")
        if config.figures is not None:
            print(f"\n{path}")
    return 0


# ---------------------------------------------------------------- the simulator


def simulator_suite(config: BenchmarkConfig) -> list[Measurement]:
    """Measure the vector environment with its observations, and a batch of size 1 for comparison."""
    cores = os.cpu_count() or 1
    rows = [first_step(config)]
    baseline = _steps_per_second(config, config.num_envs, 1)
    rows.append(Measurement(f"{config.num_envs} matches, 1 thread", baseline, _times_reference(baseline)))
    for threads in sorted({2, cores} - {1}):
        if threads <= cores:
            speed = _steps_per_second(config, config.num_envs, threads)
            rows.append(
                Measurement(
                    f"{config.num_envs} matches, {threads} threads", speed, f"{speed / baseline:.2f} x 1 thread"
                )
            )
    single = _steps_per_second(config, 1, 1)
    rows.append(
        Measurement("1 match, through the same interface", single, f"{single / baseline:.2f} x {config.num_envs}")
    )
    rows.append(Measurement("levels drawn, checked and set up", _levels_per_second(config), "levels, not steps"))
    return rows + observation_rows(config.seconds)


def first_step(config: BenchmarkConfig) -> Measurement:
    """Measure the time to the end of the first step: compiling the kernels, or loading them from the cache."""
    from regista.envs.football.batch import step_batch
    from regista.kernels.jit import compiled

    state = "from the cache" if compiled(step_batch) else "compiled now, once"
    began = time.perf_counter()
    env = _make_env(config, 1, 1)
    env.step(np.zeros(1, np.int64))
    seconds = time.perf_counter() - began
    return Measurement("kernels, until the first step", float("nan"), f"{seconds:.1f} s, {state}")


def _steps_per_second(config: BenchmarkConfig, num_envs: int, threads: int) -> float:
    """Step with random actions; episodes restart as they end."""
    return num_envs * rate(random_steps(_make_env(config, num_envs, threads)), config.seconds)


def _levels_per_second(config: BenchmarkConfig) -> float:
    env = _make_env(config, config.num_envs, 1)

    def renew(count: int) -> None:
        for _ in range(count):
            env.reset_to_levels(env.sample_levels(config.num_envs))

    return config.num_envs * rate(renew, config.seconds / 2)


def _make_env(config: BenchmarkConfig, num_envs: int, threads: int) -> Any:
    program = load_program(find_minigame(config.minigame).program, None)
    return build.make_matches(program, num_envs, TrainConfig().env, 0, threads)


# ---------------------------------------------------------------- output


def render(suite: str, rows: Sequence[Any]) -> str:
    """Return one suite as a table."""
    if suite == "language":
        return render_language(rows)
    lines = [[suite, "env steps/s", ""]]
    for row in rows:
        speed = "" if np.isnan(row.steps_per_second) else f"{row.steps_per_second:,.0f}"
        lines.append([row.what, speed.rjust(11), row.note])
    if suite == "simulator":
        low, high = REFERENCE
        lines.append(["for comparison: Google Research Football", f"{low}–{high}".rjust(11), "academies, one core"])
    if suite == "behaviors":
        low, high = ORIGINAL
        lines.append(["for comparison: Scenic alone, without a simulator", f"{low}–{high}".rjust(11), "one core"])
    return align(lines)


def _times_reference(speed: float) -> str:
    low, high = REFERENCE
    return f"{speed / high:.0f} to {speed / low:.0f} x Google Research Football"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
