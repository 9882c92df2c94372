"""The student that a training begins with: out of another run's checkpoint, and into origin.pt of its own.

A run keeps what it began with, so that it goes on after a kill whatever has become of the other run. Read next:
`ued.learning.learner`, which begins with it and may stay close to it at first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from regista.experiments.run import arguments, versions
from regista.experiments.run import config as configs
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import DAMAGE, CommandError, UsageError, refused
from regista.experiments.run.folder import LARGEST, RunFolder
from ued.config import FineTuningConfig

# Of `PPOConfig`, what a student is made of; what it observes and controls is `RunConfig.seen`
NETWORK = ("hidden_size", "hidden_layers", "shared_torso", "memory", "obs_std_floor", "team", "critic")


@dataclass(frozen=True)
class Origin:
    """A student, as a `state_dict`, and the settings of the run in which it was trained or cloned.

    `simulator` is the version on which it was; see `versions.saved_version`.
    """

    path: Path
    config: TrainConfig
    student: dict[str, Any]
    simulator: int | None


def load(path: Path) -> Origin:
    """Read the first student of a run folder or of a checkpoint. Raises `CommandError` or `CheckpointError`."""
    from ued.core import checkpoint

    file = path / "checkpoint.pt" if path.is_dir() else path
    if path.is_dir() and not file.exists():
        raise CommandError(f"{path} holds no checkpoint: give --from a run folder, or a checkpoint, of a student")
    state = checkpoint.load(file)
    try:
        config: Any = configs.from_dict(configs.run_class(state["config"]), state["config"], str(file))
        student = state["method"]["learners"][0]["ppo"]["student"]
    except (KeyError, IndexError, TypeError, AttributeError) as error:
        raise CommandError(f"{file} is a checkpoint without a student to begin with") from error
    return Origin(path, config, student, versions.saved_version(config, state, str(file)))


def of_seed(path: Path, seed: int) -> Path:
    """Return the run of this seed beneath a comparison's folder, of the one method that it has; else `path` itself.

    Raises `CommandError` for a comparison of several methods, or without that seed.
    """
    runs = [file.parent for file in path.glob("*/checkpoint.pt")] if path.is_dir() else []
    if not runs or (path / "checkpoint.pt").exists():
        return path
    of = [run for run in runs if run.name.endswith(f"-{seed}")]
    if len(of) != 1:
        raise CommandError(
            f"{path} holds {len(of) or 'no'} runs of seed {seed}: give --from a run, or a comparison of one method "
            f"with a run of every seed"
        )
    return of[0]


def begin_all(runs: Sequence[RunFolder], path: Path | None, settings: FineTuningConfig) -> None:
    """Let runs that have not begun begin with a student, each with that of its seed; None: with none.

    Raises `CommandError` where a run has begun otherwise.
    """
    from ued.core import checkpoint

    for run in runs:
        source, kept = of_seed(path, run.config.seed) if path else None, run.path / "origin.pt"
        if not run.begun():
            origin = load(source) if source else None
            if origin is not None:
                check(origin, run.config)
            save(run, origin, settings)
            continue
        began = checkpoint.load_entry(kept, "source") if kept.exists() else None
        if began != (str(source.absolute()) if source else None):
            other = source or "a new student"
            raise CommandError(f"{run.path} began with {began or 'a new student'}; it cannot go on as if with {other}")


def like(origin: Origin, config: TrainConfig) -> TrainConfig:
    """Return settings with the network of the student, and what it sees."""
    network = {name: getattr(origin.config.ppo, name) for name in NETWORK}
    config = replace(config, ppo=replace(config.ppo, **network))
    seen = {path: value for path, value in origin.config.seen().items() if path in config.seen()}
    return arguments.replace_paths(config, seen)


def check_needed(path: Path | None, settings: FineTuningConfig) -> None:
    """Raise `UsageError` where a student is to stay close to a policy, and there is none."""
    if path is None and settings != FineTuningConfig():
        raise UsageError("--kl-to-clone and --kl-share need --from PATH, the policy to stay close to")


def check(origin: Origin, config: TrainConfig) -> None:
    """Raise `CommandError` where the student is of another network, or sees or moves something else.

    Also where both play in our simulator, and not in the same version.
    """
    if versions.present_version(config) is not None:
        versions.check_present(origin.simulator, f"{origin.path} was trained on", "no run can begin with it")
    its, ours = _student_settings(origin.config), _student_settings(config)
    if its.keys() != ours.keys():
        raise CommandError(f"{origin.path} was trained on {origin.config.minigame}, which has other observations")
    for name, value in its.items():
        if str(value) != str(ours[name]):
            raise CommandError(
                f"{origin.path} holds a student of {name} = {value}; this run cannot begin with it, for it has "
                f"{ours[name]}"
            )


def _student_settings(config: TrainConfig) -> dict[str, Any]:
    """Return by path the settings that a student's network, observations and actions depend on."""
    return config.seen() | {f"ppo.{name}": getattr(config.ppo, name) for name in NETWORK}


def save(run: RunFolder, origin: Origin | None, settings: FineTuningConfig) -> None:
    """Write what a run begins with into its folder; nothing, and what an earlier try left away, if with no student."""
    from ued.core import checkpoint

    path = run.path / "origin.pt"
    if origin is None:
        path.unlink(missing_ok=True)
        return
    fades = int(settings.kl_share * run.config.total_env_steps)
    kept = {"student": origin.student, "kl_coef": settings.kl_to_clone, "kl_env_steps": fades}
    checkpoint.save(path, kept | {"source": str(origin.path.absolute()), "minigame": origin.config.minigame})


def begin_with(run: RunFolder, method: Any) -> None:
    """Let the learners of a run begin with what its folder holds, if there is anything.

    Raises `CommandError` for a student of another number of players or agents.
    """
    from ued.core import checkpoint

    path = run.path / "origin.pt"
    if not path.exists():
        return
    state = checkpoint.load(path)
    source, minigame = state.get("source"), state.get("minigame")
    try:
        numbers = {name: state[name] for name in ("kl_coef", "kl_env_steps")}
        for name, number in numbers.items():
            if type(number) not in (int, float) or not 0 <= number < LARGEST:
                raise ValueError(f"its {name} is {number!r}")
        method.start_from(state["student"], **numbers)
    except RuntimeError as error:
        raise CommandError(
            f"{source} holds a student of {minigame}, who sees something else than "
            f"{method.upomdp.single_observation_space.shape} or moves other players than {run.config.minigame} has"
        ) from error
    except DAMAGE as error:
        raise CommandError(f"{path} is damaged: {refused(error)}") from error
