"""`regista train`: one run, from a configuration to a run folder.

    regista train 1v1Restricted --method paired --seed 0
    regista train --resume runs/1v1Restricted-paired-0

Read next: `run.folder`, what is on disk; `run.build`, what the names mean; then `ued.methods.paired`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from experiments.pictures import plots
from experiments.run import arguments, build
from experiments.run.arguments import group
from experiments.run.config import TrainConfig, presets
from experiments.run.errors import UsageError
from experiments.run.folder import RunFolder
from experiments.run.progress import Progress, count
from experiments.run.signals import StopRequest
from ued.config import setting
from ued.recorder.recorder import unique_names

DESCRIPTION = "Train students on a minigame. A run can be stopped with Ctrl-C at any time and continued with --resume."


@dataclass(frozen=True)
class TrainFlags:
    """What is typed after `regista train`."""

    out: Path | None = setting(None, "run folder (default runs/MINIGAME-METHOD-SEED)")
    resume: Path | None = setting(None, "continue this run; only its budget and bookkeeping may change")
    preset: Literal["fast", "thesis"] = setting("fast", "starting point of the settings: fast, or thesis for Table 4.2")
    config: TrainConfig = group(TrainConfig, "run")


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    run = _open_run(argv)
    with run.locked(), StopRequest() as stop:
        done = train(run, stop)
    plots.learning_curves({run.config.method: [run.path]}, run.path / "learning_curve.png")
    if stop:
        print(f"stopped at {count(done)} env_steps; continue with: regista train --resume {run.path}")
    return stop.exit_code


def train(run: RunFolder, stop: StopRequest) -> int:
    """Train until the budget is spent or somebody asks to stop; give the env_steps done."""
    from experiments.run.evaluator import TestScenes
    from experiments.run.recording import RunRecorder

    config = run.config
    program = build.find_minigame(config.minigame).program
    run.keep_program(program)
    upomdp = build.make_upomdp(program, config.num_envs, config.env, config.seed, config.threads)
    method = build.make_method(config, upomdp)
    tests = TestScenes(config, config.eval_episodes)
    state = run.load()
    if state is not None:
        method.load_state_dict(state["method"])
    recorder = RunRecorder(run, upomdp, method.updates)
    progress = Progress(config.total_env_steps, method.env_steps)
    elapsed = (state or {}).get("elapsed", 0.0)

    while method.env_steps < config.total_env_steps and not stop:
        began, before = time.perf_counter(), method.env_steps
        metrics = method.update()
        if tests.due(before, method.env_steps, last=method.env_steps >= config.total_env_steps):
            metrics |= tests.metrics(method.student)
        elapsed += time.perf_counter() - began
        write_update(run, method, {**metrics, "time/elapsed": elapsed}, unique_names(upomdp.draws))
        recorder.update(method, metrics)
        progress.show(method.env_steps, headline(metrics))
        if run.checkpoint_due():
            save(run, method, elapsed)
            recorder.flush()

    if method.updates > run.saved_update:
        save(run, method, elapsed)
    recorder.close()
    progress.finish(f"{run.path}: {count(method.env_steps)} env_steps, {method.updates} updates, {elapsed:.0f} s")
    return method.env_steps


def save(run: RunFolder, method: Any, elapsed: float) -> None:
    """Write the checkpoint: all that `train` needs to go on as if it had never stopped."""
    progress = {"update": method.updates, "env_steps": method.env_steps, "elapsed": elapsed}
    run.save({**progress, "method": method.state_dict()})


def write_update(run: RunFolder, method: Any, metrics: dict[str, float], names: list[str]) -> None:
    """Add one row to metrics.csv and one per trained level to levels.csv; wall-clock columns come last."""
    row: dict[str, Any] = {"update": method.updates, "env_steps": method.env_steps}
    rest = {name: value for name, value in metrics.items() if name not in ("updates", "env_steps")}
    run.metrics.append([row | dict(sorted(rest.items(), key=lambda item: item[0].startswith("time/")))])
    batch = method.last
    if batch is None:
        return
    rows = []
    for level, theta in enumerate(batch.theta):
        entry: dict[str, Any] = {"update": method.updates}
        entry |= {f"theta/{name}": round(float(value), 5) for name, value in zip(names, theta, strict=True)}
        entry |= {f"return/{name}": round(float(values[level]), 5) for name, values in batch.returns.items()}
        entry["score"] = round(float(batch.score[level]), 5)
        rows.append(entry)
    run.levels.append(rows)


def headline(metrics: dict[str, float]) -> dict[str, float]:
    """Give the few numbers that the progress line shows."""
    return {
        name.partition("/")[2] or name: value
        for name, value in metrics.items()
        if name.startswith("return/") or name == "regret"
    }


def _open_run(argv: Sequence[str]) -> RunFolder:
    typed = arguments.typed_settings(TrainFlags(), argv, "train", DESCRIPTION)
    if "resume" in typed:
        return _resume(typed)
    base = TrainFlags(config=presets()[typed.get("preset", "fast")])
    flags = arguments.replace_paths(base, typed)
    config = replace(flags.config, minigame=build.settled_name(flags.config.minigame))
    name = build.find_minigame(config.minigame).name
    build.find_method(config.method)
    return RunFolder.create(flags.out or Path("runs") / f"{name}-{config.method}-{config.seed}", config)


def _resume(typed: dict[str, Any]) -> RunFolder:
    path = typed.pop("resume")
    for name in ("out", "preset"):
        if name in typed:
            raise UsageError(f"--{name} and --resume exclude each other: a resumed run stays in its folder")
    run = RunFolder.open(path)
    flags = arguments.replace_paths(TrainFlags(config=run.config), typed)
    run.extend(flags.config)
    return run
