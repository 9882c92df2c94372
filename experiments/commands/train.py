"""`regista train`: train one run and write its run folder, or the runs of several seeds in parallel.

    regista train 1v1Restricted --method paired --seed 0
    regista train examples/hopper.py:hopper --method plr
    regista train --resume runs/1v1Restricted-paired-0
    regista train --config runs/1v1Restricted-paired-0 --seed 1      # the same settings, another seed
    regista train 1v1Restricted --method paired --seeds 5            # in parallel, one run per core
    regista train 1v1Free --method dr --from runs/1v1Free-clone-0 --kl-to-clone 0.5

Read next: `run.folder`, the files; `run.build`, from names to objects; then `ued.methods.paired`.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

from regista.experiments.pictures import curves, plots
from regista.experiments.run import arguments, build, origin, outlook, starting, versions
from regista.experiments.run.arguments import group, option
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import DAMAGE, CommandError, UsageError, read_from, refused
from regista.experiments.run.folder import EVALUATED_ALONE, RunFolder
from regista.experiments.run.launch import seeds
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.launch.variants import Variant
from regista.experiments.run.launch.workers import LaunchConfig
from regista.experiments.run.notes import telling_warnings, warn
from regista.experiments.run.progress import Progress, count, counted
from regista.experiments.run.reporting import Console, Reporters
from ued.config import LARGEST_SEED, FineTuningConfig, setting
from ued.core.task import Task

DESCRIPTION = (
    "Train students on a game or task. Ctrl-C saves and stops a run; --resume continues it. A run uses one core well, "
    "so runs are the unit of parallelism: on more cores train more --seeds, or compare methods."
)
OF_SEVERAL = {"launch.launcher", "launch.processes"}


@dataclass(frozen=True)
class TrainFlags:
    """Arguments of `regista train`."""

    out: Path | None = setting(
        None,
        "run folder (default runs/MINIGAME-METHOD-SEED); with --seeds, their folder (default runs/MINIGAME-METHOD)",
    )
    resume: Path | None = setting(
        None, "continue this run, or the runs in this folder; only their budget and logging may change"
    )
    seeds: int | None = setting(
        None,
        "number of runs to train in parallel processes, with consecutive seeds from --seed, in folders METHOD-SEED",
        ">=1",
        most=10_000,
    )
    from_: Path | None = setting(
        None, "initialize the student from this run or checkpoint, for example one from regista clone"
    )
    config_: Path | None = setting(None, "settings from a config.json or run folder")
    preset: Literal["fast", "thesis"] = setting("fast", "preset of settings: fast, or thesis (images; takes a day)")
    format: plots.PictureFormat = setting("png", plots.FORMAT_HELP)
    connect: str | None = option(None, "also stream the recording to a running Rerun viewer", metavar="HOST:PORT")
    config: Any = group(TrainConfig, "run")
    launch: LaunchConfig = group(LaunchConfig, "with --seeds", prefix="")
    fine_tuning: FineTuningConfig = group(FineTuningConfig, "with --from", prefix="")


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    typed = _typed(argv)
    several = seeds.opened(typed["resume"]) if "resume" in typed else []
    if "seeds" in typed or several:
        return _train_several(typed, several)
    for name in sorted(typed.keys() & OF_SEVERAL):
        raise UsageError(f"{arguments.flag_name(name.partition('.')[2])} needs --seeds, or --resume with several runs")
    connect, kind = typed.pop("connect", None), typed.pop("format", "png")
    run = _resume(typed) if "resume" in typed else _begin(typed)
    stop = StopRequest()
    with run.removed_if_refused(), run.locked():
        done = train(run, stop, connect)
    with read_from(f"{run.metrics.path} is"):
        curves.learning_curves({run.config.method: [run.path]}, run.path / f"learning_curve.{kind}")
    if stop:
        print(f"stopped at {count(done)} env_steps; continue with: regista train --resume {run.path}")
    return stop.exit_code


def train(run: RunFolder, stop: StopRequest, connect: str | None = None) -> int:
    """Train until the budget is spent or a stop is requested; return the completed env_steps.

    `connect` is the address of a Rerun viewer that shows the recording live.
    Before training starts there is nothing to save, so a signal ends the process at once.
    """
    from regista.experiments.run.evaluator import EvalScenes, check_tests

    config, game = run.config, build.find_game(run.config.minigame)
    run.save_source(game.source(config))
    task = game.task(config)
    method = build.make_method(config, build.make_upomdp(task.make, config.num_envs, config.seed))
    origin.begin_with(run, method)
    check_tests(task, method.upomdp, game.name)
    scenes = EvalScenes(config, game, config.eval_episodes) if config.eval_every else None
    elapsed = restore(run, method)
    progress = Progress(config.total_env_steps, method.env_steps)
    reporters = open_reporters(run, task, method, progress, connect)
    outlook.tell(config, method, progress.say)
    outlook.warn_of_annealing(config)

    with stop, telling_warnings():
        while method.env_steps < config.total_env_steps and not stop:
            began, before = time.perf_counter(), method.env_steps
            metrics = method.update()
            last = method.env_steps >= config.total_env_steps
            if scenes is not None and scenes.due(before, method.env_steps, last):
                metrics |= scenes.metrics(method.student)
            elapsed += (seconds := time.perf_counter() - began)
            reporters.report(method, metrics | {"time/elapsed": elapsed})
            run.save_config()  # after the first update, so a run that fails earlier stays unchanged
            if run.checkpoint_due(seconds):
                save(run, method, elapsed)
                reporters.flush()
        if method.updates > run.saved_update:
            save(run, method, elapsed)
    run.save_config()
    finish(run, method, reporters, progress, elapsed)
    return method.env_steps


def finish(run: RunFolder, method: Any, reporters: Reporters, progress: Progress, elapsed: float) -> None:
    """Close the reporters; print the progress, and each student or teacher that rarely or never took gradient steps."""
    reporters.close()
    progress.finish(
        f"{run.path}: {count(method.env_steps)} env_steps, {counted(method.updates, 'update')}, {elapsed:.0f} s"
    )
    for event in reporters.watch.learning.seldom():
        progress.say(event.text)


def open_reporters(
    run: RunFolder, task: Task, method: Any, progress: Progress, connect: str | None = None
) -> Reporters:
    """Return the reporters of a run: its tables, the terminal, its recording and trackers."""
    from regista.experiments.run.trackers import make_tracker

    reporters = Reporters(run, method.upomdp)
    reporters.add("shown", lambda: Console(progress))
    if run.config.record:
        from regista.experiments.run.recording import RunRecorder

        reporters.add("recorded", lambda: RunRecorder(run, task, method, connect))
    for name in run.config.report:
        reporters.add(f"logged to {name}", partial(make_tracker, name, run, method.env_steps))
    return reporters


def restore(run: RunFolder, method: Any) -> float:
    """Restore the run's checkpoint, if it has one; return the seconds of training so far.

    A run that ended before its first checkpoint restarts from zero, with a warning.
    Raises `CommandError` if the environments have changed, or for another version of the simulator.
    """
    from regista.experiments.run.evaluator import load_students

    state = run.load()
    if state is None:
        if done := run.env_steps():
            warn(f"{run.path} stopped at {count(done)} env_steps, before its first checkpoint: it restarts from zero")
        run.cut_back(0)
        return 0.0
    version = versions.saved_version(run.config, state, str(run.checkpoint))
    versions.check_present(version, f"{run.checkpoint} was trained on", EVALUATED_ALONE)
    try:
        method.load_state_dict(state["method"])
    except DAMAGE as error:  # damaged, another network, or the state of the environments has another layout
        load_students(run, method, state["method"])  # raises if it cannot be evaluated, either
        raise CommandError(f"{run.path} can be evaluated, but no longer resumed: {refused(error)}") from error
    run.cut_back(state["update"])
    run.note_processor()
    return float(state["elapsed"])


def save(run: RunFolder, method: Any, elapsed: float) -> None:
    """Write the checkpoint: the state from which `train` continues exactly.

    If the environments do not support saving their state, open episodes are restarted.
    """
    from ued.adapters.policy import spaces_of

    progress: dict[str, Any] = {"update": method.updates, "env_steps": method.env_steps, "elapsed": elapsed}
    whole = method.upomdp.supports_state
    progress |= {"spaces": spaces_of(method.upomdp), **versions.stamp(run.config)}
    run.save({**progress, "method": method.state_dict() if whole else method.state_dict(episodes=False)})


def _typed(argv: Sequence[str]) -> dict[str, Any]:
    """Return the given values by path of the field."""
    others = {case: [TrainFlags(config=config) for config in configs] for case, configs in _others(argv).items()}
    return arguments.typed_settings(TrainFlags(config=_known(argv)), argv, "train", DESCRIPTION, others)


def _train_several(typed: dict[str, Any], resumed: Sequence[RunFolder]) -> int:
    """Train the runs of several seeds, or continue the `resumed` ones; return the exit code."""
    if "connect" in typed:
        raise UsageError("--connect shows one run; give it to a single run, without --seeds")
    if "format" in typed:
        raise UsageError("--format is of the picture of one run; of several, use regista compare --format")
    if "resume" in typed:
        if "seeds" in typed:
            raise UsageError(
                "--seeds and --resume exclude each other; to add seeds, repeat the first command with more"
            )
        return _resume_several(typed, resumed)
    flags, _, stem = _settings(typed)
    config, count = flags.config, flags.seeds or 1
    if config.seed + count - 1 > LARGEST_SEED:
        raise UsageError(f"--seed {config.seed} --seeds {count} needs seeds above {LARGEST_SEED}, the largest")
    folder = flags.out or Path("runs") / stem
    several = range(config.seed, config.seed + count)
    runs = seeds.prepare(folder, [Variant(config.method, config)], several, flags.from_, flags.fine_tuning)
    return seeds.train_together(runs, flags.launch)


def _resume_several(typed: dict[str, Any], runs: Sequence[RunFolder]) -> int:
    del typed["resume"]
    _check_used(typed, [run.config.method for run in runs])
    runs = [_extended(run, typed) for run in runs]
    for run in runs:
        with run.locked():
            run.save_config()
    launching = {name: value for name, value in typed.items() if name in OF_SEVERAL}
    return seeds.train_together(runs, arguments.replace_paths(TrainFlags(), launching).launch)


def _begin(typed: dict[str, Any]) -> RunFolder:
    flags, source, stem = _settings(typed)
    if source is not None:
        origin.check(source, flags.config)
    out = flags.out or Path("runs") / f"{stem}-{flags.config.seed}"
    return RunFolder.create(out, flags.config, lambda run: origin.save(run, source, flags.fine_tuning))


def _settings(typed: dict[str, Any]) -> tuple[TrainFlags, origin.Origin | None, str]:
    """Return the settings of new runs, the origin of their students or None, and the default name of their folder."""
    path = typed.get("from_")
    if path is not None and "seeds" in typed:  # a folder may hold a student for each seed; all have the same network
        path = origin.of_seed(path, int(typed.get("config.seed", 0)))
    source = origin.load(path) if path is not None else None
    starting.warn_of_origin(typed)
    usual = source.config.minigame if source else TrainConfig().minigame
    game, start = starting.start_of(typed, typed.get("config.minigame"), usual)
    base = TrainFlags(config=origin.like(source, start) if source else start)
    flags = arguments.replace_paths(base, typed)
    flags = replace(flags, config=replace(flags.config, minigame=game.name))
    _check_used(typed, [flags.config.method])
    build.find_device(flags.config.device)
    origin.check_needed(flags.from_, flags.fine_tuning)
    return flags, source, f"{game.short}-{flags.config.method}{'-from-clone' if source else ''}"


def _check_used(typed: Iterable[str], methods: Iterable[str]) -> None:
    """Raise `UsageError` for flags of methods other than these; settings from files and presets are not flags."""
    build.check_used((name.removeprefix("config.") for name in typed), methods)


def _known(argv: Sequence[str]) -> Any:
    """Return the base settings: those of the run on the command line, or else those of the game or task."""
    named = _named_run(argv)
    return RunFolder.open(named).config if named else starting.settings_for(argv)


def _others(argv: Sequence[str]) -> dict[str, list[Any]]:
    """Return the settings of other games, tasks and presets; none if a run determines them."""
    return {} if _named_run(argv) else starting.other_settings(argv)


def _named_run(argv: Sequence[str]) -> Path | None:
    pairs = [(flag, Path(path)) for flag, path in itertools.pairwise(argv) if flag in ("--resume", "--from")]
    runs = [run.path for flag, path in pairs if flag == "--resume" for run in seeds.opened(path)]
    return next((path for _, path in pairs if (path / "config.json").exists()), next(iter(runs), None))


def _resume(typed: dict[str, Any]) -> RunFolder:
    run = RunFolder.open(typed.pop("resume"))
    _check_used(typed, [run.config.method])
    return _extended(run, typed)


def _extended(run: RunFolder, typed: dict[str, Any]) -> RunFolder:
    """Apply new settings to a run; reject those that would change its results."""
    for name in ("out", "preset", "from_", "config_", "fine_tuning.kl_to_clone", "fine_tuning.kl_share"):
        if name in typed:
            flag = arguments.flag_name(name.partition(".")[2] or name)
            raise UsageError(f"{flag} and --resume exclude each other: a resumed run keeps its folder and its settings")
    if run.label == "clone":
        raise CommandError(f"{run.path} is a clone; start a new run from it: regista train --from {run.path}")
    if "config.minigame" in typed:
        typed = {**typed, "config.minigame": build.find_game(typed["config.minigame"]).name}
    flags = arguments.replace_paths(TrainFlags(config=run.config), typed)
    run.extend(flags.config)
    return run
