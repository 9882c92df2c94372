"""Base settings of a command line, before its flags: those of its preset and its game.

Read next: `run.config`, the presets; `run.games`, settings of games.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from regista.experiments.run.build import find_game
from regista.experiments.run.errors import UsageError
from regista.experiments.run.games import all_starts

TAKING_TEXT = (  # flags of train and compare whose value may look like a game
    *("--out", "--from", "--resume", "--rrd", "--connect", "--scenario", "--model", "-m", "--param", "-p"),
    *("--method", "--grf-python"),
)


def settings_for(argv: Sequence[str]) -> Any:
    """Return the base settings of a command line."""
    from regista.experiments.run.config import TrainConfig

    return find_game(_named(argv) or TrainConfig().minigame).start(preset_of(argv))


def preset_of(argv: Sequence[str]) -> str:
    """Return the preset on the command line, by default `fast`."""
    from regista.experiments.run.config import presets

    pairs = [*itertools.pairwise(argv), *(word.partition("=")[::2] for word in argv)]
    typed = [value for flag, value in pairs if flag == "--preset" and value in presets()]
    return typed[-1] if typed else "fast"


def other_settings(argv: Sequence[str]) -> dict[str, list[Any]]:
    """Return the base settings for other presets and games, by case, for the help."""
    from regista.experiments.run.config import TrainConfig, presets, task_presets

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
