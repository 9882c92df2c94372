"""Initial students: read from another run's checkpoint and saved in the new run's origin.pt.

A run saves its initial student, so that it can resume even if the other run has changed. Read next:
`ued.learning.learner`, which starts from it and may be regularized toward it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from regista.experiments.run import arguments, versions
from regista.experiments.run import config as configs
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import DAMAGE, CommandError, UsageError, refused
from regista.experiments.run.folder import LARGEST, RunFolder
from regista.experiments.run.notes import warn
from ued.config import FineTuningConfig

# Settings of `PPOConfig` that determine the network; `RunConfig.seen` determines observations and control
NETWORK = (
    *("network", "hidden_size", "hidden_layers", "head_size", "shared_torso", "memory"),
    *("obs_std_floor", "team", "critic"),
)


@dataclass(frozen=True)
class Origin:
    """A student, as a `state_dict`, and the settings of the run that trained or cloned it.

    `simulator` is the simulator version of that run; see `versions.saved_version`.
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
        raise CommandError(f"{path} holds no checkpoint: --from takes a run folder or a checkpoint with a student")
    state = checkpoint.load(file)
    try:
        config: Any = configs.from_dict(configs.run_class(state["config"]), state["config"], str(file))
        student = state["method"]["learners"][0]["ppo"]["student"]
    except (KeyError, IndexError, TypeError, AttributeError) as error:
        raise CommandError(f"{file} is a checkpoint without a student") from error
    return Origin(path, config, student, versions.saved_version(config, state, str(file)))


def of_seed(path: Path, seed: int) -> Path:
    """Return the run with this seed in the folder of a comparison of one method; otherwise `path` itself.

    Raises `CommandError` for a comparison of several methods, or without that seed.
    """
    runs = [file.parent for file in path.glob("*/checkpoint.pt")] if path.is_dir() else []
    if not runs or (path / "checkpoint.pt").exists():
        return path
    of = [run for run in runs if run.name.endswith(f"-{seed}")]
    if len(of) != 1:
        raise CommandError(
            f"{path} holds {len(of) or 'no'} runs of seed {seed}: --from takes a run, or a comparison of one method "
            f"with a run of every seed"
        )
    return of[0]


def begin_all(runs: Sequence[RunFolder], path: Path | None, settings: FineTuningConfig) -> None:
    """Set the initial student of new runs, by seed; None: random initialization.

    Raises `CommandError` if a run has started from another student, or with another KL regularizer.
    """
    sources = [of_seed(path, run.config.seed) if path else None for run in runs]
    begun: dict[Path | None, dict[str, Any]] = {}  # content of origin.pt of existing runs, by source
    for run, source in zip(runs, sources, strict=True):
        if run.begun():
            begun[source] = _began(run, source, settings)
    for run, source in zip(runs, sources, strict=True):
        if not run.begun():
            origin = load(source) if source else None
            if origin is not None:
                check(origin, run.config)
                _check_unchanged(origin, begun.get(source, {}).get("student"))
            save(run, origin, settings)


def _began(run: RunFolder, source: Path | None, settings: FineTuningConfig) -> dict[str, Any]:
    """Return the content of a run's origin.pt, empty without one; see `begin_all` for errors."""
    from ued.core import checkpoint

    saved = run.path / "origin.pt"
    state = checkpoint.load(saved) if saved.exists() else {}
    began = state.get("source")
    if began != (str(source.absolute()) if source else None):
        other = source or "a new student"
        raise CommandError(f"{run.path} started from {began or 'a new student'}; it cannot continue with {other}")
    if source:
        _check_kl(run, state, settings)
    return state


def _check_unchanged(origin: Origin, student: Mapping[str, Any] | None) -> None:
    """Raise `CommandError` unless the origin still has the `student` from which other runs started."""
    import torch

    if student is not None and not all(torch.equal(student[name], now) for name, now in origin.student.items()):
        raise CommandError(
            f"{origin.path} has been trained since other runs started from it: runs of one comparison start from the "
            "same student; choose another --out"
        )


def _check_kl(run: RunFolder, state: Mapping[str, Any], settings: FineTuningConfig) -> None:
    """Raise `CommandError` if a run has started with another KL regularizer; older files lack its `kl_share`."""
    coef = state.get("kl_coef")
    share = state.get("kl_share", settings.kl_share) if coef else settings.kl_share  # irrelevant without a coefficient
    if (coef, share) != (settings.kl_to_clone, settings.kl_share):
        raise CommandError(
            f"{run.path} started with --kl-to-clone {coef} --kl-share {share}; it cannot continue with "
            f"{settings.kl_to_clone} and {settings.kl_share}"
        )


def like(origin: Origin, config: TrainConfig) -> TrainConfig:
    """Return settings with the student's network, observations and control."""
    network = {name: getattr(origin.config.ppo, name) for name in NETWORK}
    config = replace(config, ppo=replace(config.ppo, **network))
    seen = {path: value for path, value in origin.config.seen().items() if path in config.seen()}
    return arguments.replace_paths(config, seen)


def check_needed(path: Path | None, settings: FineTuningConfig) -> None:
    """Raise `UsageError` if KL settings are given without a reference policy."""
    if path is None and settings != FineTuningConfig():
        raise UsageError("--kl-to-clone and --kl-share need --from PATH, the reference policy")


def check(origin: Origin, config: TrainConfig) -> None:
    """Raise `CommandError` if the student has another network, other observations or other control.

    Raises it, too, if the student was trained on another version of our simulator. Warns if both runs play the same
    program with different parameters.
    """
    if versions.present_version(config) is not None:
        versions.check_present(origin.simulator, f"{origin.path} was trained on", "no run can start from it")
    its, ours = _student_settings(origin.config), _student_settings(config)
    if its.keys() != ours.keys():
        raise CommandError(f"{origin.path} was trained on {origin.config.minigame}, which has other observations")
    for name, value in its.items():
        if str(value) != str(ours[name]):
            raise CommandError(
                f"{origin.path} holds a student with {name} = {value}; this run cannot start from it, since it has "
                f"{ours[name]}"
            )
    its_program, ours_program = getattr(origin.config, "program", None), getattr(config, "program", None)
    if origin.config.minigame == config.minigame and its_program != ours_program:
        differing = configs.differences(its_program, ours_program).items()
        told = ", ".join(f"{name} = {_listed(old)} there and {_listed(new)} here" for name, (old, new) in differing)
        warn(f"warning: {origin.path} was trained with other settings of the program: {told}")


def _listed(value: Any) -> str:
    return (", ".join(value) if isinstance(value, tuple) else value) or "none"


def _student_settings(config: TrainConfig) -> dict[str, Any]:
    """Return the settings that determine a student's network, observations and actions, by path."""
    return config.seen() | {f"ppo.{name}": getattr(config.ppo, name) for name in NETWORK}


def save(run: RunFolder, origin: Origin | None, settings: FineTuningConfig) -> None:
    """Write the initial student of a run into its folder; without one, remove the file of an earlier attempt."""
    from ued.core import checkpoint

    path = run.path / "origin.pt"
    if origin is None:
        path.unlink(missing_ok=True)
        return
    fades = int(settings.kl_share * run.config.total_env_steps)
    saved = {"student": origin.student, "kl_coef": settings.kl_to_clone, "kl_env_steps": fades}
    saved |= {"kl_share": settings.kl_share}
    checkpoint.save(path, saved | {"source": str(origin.path.absolute()), "minigame": origin.config.minigame})


def begin_with(run: RunFolder, method: Any) -> None:
    """Initialize the learners of a run from its origin.pt, if it has one.

    Raises `CommandError` for a student with another number of players or agents.
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
            f"{source} holds a student of {minigame}, which observes something other than "
            f"{method.upomdp.single_observation_space.shape} or controls other players than {run.config.minigame} has"
        ) from error
    except DAMAGE as error:
        raise CommandError(f"{path} is damaged: {refused(error)}") from error
