"""Base settings of a command line, before its flags: those of its preset and its game, or of a file, `--config`.

Read next: `run.config`, the presets; `run.games`, settings of games.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from regista.experiments.run.build import find_game
from regista.experiments.run.errors import UsageError
from regista.experiments.run.games import all_starts
from regista.experiments.run.notes import warn

TAKING_TEXT = (  # flags of train and compare whose value may look like a game
    *("--out", "--from", "--resume", "--config", "--rrd", "--connect", "--scenario", "--model", "-m", "--param", "-p"),
    *("--method", "--grf-python"),
)


def settings_for(argv: Sequence[str]) -> Any:
    """Return the base settings of a command line."""
    from regista.experiments.run.config import TrainConfig

    if file := config_file(argv):
        return saved_settings(file)
    return find_game(_named(argv) or TrainConfig().minigame).start(preset_of(argv))


def config_file(argv: Sequence[str]) -> Path | None:
    """Return the file of `--config` on the command line, or None."""
    pairs = [*itertools.pairwise(argv), *(word.partition("=")[::2] for word in argv if "=" in word)]
    typed = [value for flag, value in pairs if flag == "--config"]
    return Path(typed[-1]) if typed else None


def saved_settings(path: Path) -> Any:
    """Return the settings in a config.json, given by its path or its run folder.

    Raises `UsageError` without such a file, `ConfigError` for unknown settings and values of the wrong type.
    """
    from regista.experiments.run import config as configs

    file = path / "config.json" if path.is_dir() else path
    if not file.is_file():
        raise UsageError(f"--config: there is no file {file}; give the config.json of a run, or its folder")
    return configs.load(None, file)


def start_of(typed: Mapping[str, Any], minigame: str | None, usual: str) -> tuple[Any, Any]:
    """Return the game and the base settings of the `typed` values: those of `--config`, or the game's preset.

    `minigame` is the name of the game, if one is given; `usual` is the name without it and without `--config`.
    Raises `UsageError` for settings of football with another kind of task, and vice versa.
    """
    path = typed.get("config_")
    if path is None:
        game = find_game(minigame or usual)
        return game, game.start(typed.get("preset", "fast"))
    if "preset" in typed:
        raise UsageError("--preset and --config exclude each other: the file has all settings")
    start = saved_settings(path)
    game = find_game(minigame or start.minigame)
    if minigame and type(game.start("fast")) is not type(start):
        raise UsageError(f"--config {path} has settings for {start.minigame}, which do not apply to {game.short}")
    return game, start


def warn_of_origin(typed: Mapping[str, Any]) -> None:
    """Warn if the run of `--config` started from a student but `--from`, which is not a setting, is missing."""
    from ued.core import checkpoint

    path = typed.get("config_")
    if path is None or "from_" in typed:
        return
    file = (path if path.is_dir() else path.parent) / "origin.pt"
    if file.exists():
        source = checkpoint.load_entry(file, "source")
        warn(
            f"warning: {file.parent} started from {source}; this run starts from a new student without --from {source}"
        )


def preset_of(argv: Sequence[str]) -> str:
    """Return the preset on the command line, by default `fast`."""
    from regista.experiments.run.config import presets

    pairs = [*itertools.pairwise(argv), *(word.partition("=")[::2] for word in argv)]
    typed = [value for flag, value in pairs if flag == "--preset" and value in presets()]
    return typed[-1] if typed else "fast"


def other_settings(argv: Sequence[str]) -> dict[str, list[Any]]:
    """Return the base settings for other presets and games, by case, for the help."""
    from regista.experiments.run.config import TrainConfig, presets, task_presets

    if config_file(argv):
        return {}
    typed, game, usual = preset_of(argv), _named(argv), TrainConfig().minigame
    others = [name for name in presets() if name != typed]
    cases = {f"with --preset {name}": [find_game(game or usual).start(name)] for name in others}
    if game is None:
        cases["for other games"] = all_starts(typed)
    if game is None or find_game(game).start(typed).engine is not None:
        cases["for tasks"] = [task_presets()[typed]]
    return cases


def _named(argv: Sequence[str]) -> str | None:
    """Return the game or task on the command line, or None; values of flags in TAKING_TEXT are skipped."""
    pairs = itertools.pairwise(["", *argv])
    return next((word for flag, word in pairs if flag not in TAKING_TEXT and _is_game(word)), None)


def _is_game(word: str) -> bool:
    try:
        return not word.startswith("-") and bool(find_game(word))
    except UsageError:
        return False
