"""All runs of a path: a run folder, or a folder of runs, such as the output of `regista compare`.

Read next: `run.folder`, one run; `commands.evaluate`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from regista.experiments.run import config as configs
from regista.experiments.run import versions
from regista.experiments.run.errors import CommandError
from regista.experiments.run.folder import MAY_CHANGE, RunFolder, advice_on_file
from regista.experiments.run.notes import warn
from regista.experiments.run.shipped import located

DEPTH = 2  # levels of searched folders: runs/compare-maze/plr-0


def open_runs(paths: Iterable[Path]) -> list[RunFolder]:
    """Return the runs of these paths; of a folder of runs, those with a checkpoint, by label and seed.

    A path may name a shipped policy. Raises `CommandError` for a path without runs.
    """
    found: dict[Path, RunFolder] = {}  # each run once, at its first position: the first is the reference of a table
    for path in map(located, paths):
        for run in [RunFolder.open(path)] if (path / "config.json").exists() else _runs_in(path):
            found.setdefault(run.path.resolve(), run)
    runs = [*found.values()]
    _warn_of_copies(runs)
    return runs


def _warn_of_copies(runs: Sequence[RunFolder]) -> None:
    """Warn of folders that hold copies of one run: their results are not independent."""
    first: dict[str, RunFolder] = {}
    for run in runs:
        other = first.setdefault(str(run.about.get("id") or run.path.resolve()), run)
        if other is not run:
            warn(f"{run.path} is a copy of {other.path}, so they are one run, not two: leave one of them out")


def _runs_in(folder: Path) -> list[RunFolder]:
    runs = [RunFolder.open(path) for path in _below(folder, DEPTH)]
    if not runs:
        wrong = advice_on_file(folder) or "it has no config.json, and holds no run folders"
        raise CommandError(f"{folder} is not a run folder: {wrong}")
    begun = [run for run in runs if run.checkpoint.exists()]
    if not begun:
        raise CommandError(f"none of the {len(runs)} runs in {folder} has a checkpoint yet; train them first")
    for run in runs:
        if run not in begun:
            warn(f"{run.path} has no checkpoint yet; it is skipped")
    return sorted(begun, key=lambda run: (run.label, run.config.seed, str(run.path)))


def _below(folder: Path, depth: int) -> Iterator[Path]:
    for entry in sorted(folder.iterdir()) if folder.is_dir() and depth else ():
        if (entry / "config.json").exists():
            yield entry
        elif entry.is_dir():
            yield from _below(entry, depth - 1)


def by_game(runs: Sequence[RunFolder]) -> dict[str, list[RunFolder]]:
    """Return the runs by the name of their game, in order of first appearance."""
    groups: dict[str, list[RunFolder]] = {}
    for run in runs:
        groups.setdefault(run.config.minigame, []).append(run)
    return groups


def check_comparable(runs: Sequence[RunFolder], verb: str = "evaluate") -> None:
    """Check that these runs may share the tables of one game; warn of rows with different settings.

    Raises `CommandError` for runs of several games or simulator versions; the message says to `verb` them separately.
    """
    check_one_game(runs, verb)
    versions.check_alike({run.path: run.simulator for run in runs}, verb)
    _warn_of_mixtures(runs, verb)
    warn_of_changed_tasks(runs)


def warn_of_changed_tasks(runs: Sequence[RunFolder]) -> None:
    """Warn of runs that share tables, but began with different texts of their task's file."""
    begun = [(run.path / "task.py", run) for run in runs if (run.path / "task.py").is_file()]
    texts = [file.read_text(errors="replace") for file, _ in begun]
    other = next((k for k, text in enumerate(texts) if text != texts[0]), None)
    if other is not None:
        (one, run), (two, _) = begun[0], begun[other]
        warn(f"{run.config.minigame} changed between these runs: compare {one} with {two}")


def check_one_game(runs: Sequence[RunFolder], verb: str = "evaluate") -> None:
    """Raise `CommandError` for runs of several games or tasks, or with different settings of their program."""
    games = {run.config.minigame for run in runs}
    if len(games) > 1:
        raise CommandError(f"these runs are of different minigames: {', '.join(sorted(games))}; {verb} them separately")
    first, *others = [_played_by(run.config) for run in runs]
    for run, other in zip(runs[1:], others, strict=True):
        for name in first:
            if first[name] != other.get(name, first[name]):
                raise CommandError(
                    f"{runs[0].path} has {name} = {first[name]!r}, {run.path} has {other[name]!r}: their environments "
                    f"are different; {verb} them separately"
                )


def _played_by(config: Any) -> dict[str, Any]:
    """Return the settings that determine the episodes of an evaluation; empty for a Python task."""
    env = getattr(config, "env", None)
    if env is None:
        return {}
    others = ("rewards", "engine", "grf_python", "grf_workers", "pixels")  # goals are the reward, the command's engine
    played = {name: value for name, value in vars(env).items() if name not in others}
    if env.engine == "grf":
        del played["engine_spread"]  # GRF cannot be randomized
    return {"program": config.program, **played}


def _warn_of_mixtures(runs: Sequence[RunFolder], verb: str) -> None:
    """Warn of runs that share a row of a table although they were trained with different settings."""
    first: dict[str, RunFolder] = {}
    for run in runs:
        like = first.setdefault(run.label, run)
        if type(run.config) is not type(like.config):
            continue
        other = configs.differences(like.config, run.config)
        names = [name for name in other if name not in (*MAY_CHANGE, "seed", "threads")]
        if names:
            warn(
                f"{run.path} and {like.path} share the row '{run.label}', but differ in {', '.join(names[:3])}"
                f"{' and more' if len(names) > 3 else ''}; {verb} them separately to distinguish them"
            )
