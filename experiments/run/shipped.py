"""Trained policies that are installed with Regista: `shipped:NAME`, by the name of their game.

    regista play --player shipped:maze
    regista evaluate shipped:maze

Each is a run folder with only config.json and a checkpoint of the student. It is read like any run folder, with the
same checks. `python -m lab.policies` trains them. Read next: `run.folder`.
"""

from __future__ import annotations

from pathlib import Path

from regista.experiments.run.errors import UsageError, nearest

PREFIX = "shipped:"
FOLDER = Path(__file__).resolve().parents[1] / "policies"


def names() -> list[str]:
    """Return the shipped policies, such as `shipped:maze`."""
    files = FOLDER.rglob("config.json")
    return [f"{PREFIX}{name}" for name in sorted(file.parent.relative_to(FOLDER).as_posix() for file in files)]


def of_game(game: str) -> str:
    """Return the shipped policy of a game or built-in task, by its short name; "" if there is none."""
    name = f"{PREFIX}{game}"
    return name if name in names() else ""


def is_name(word: str | Path) -> bool:
    """Return whether a word names a shipped policy, known or not."""
    return str(word).startswith(PREFIX)


def located(word: str | Path) -> Path:
    """Return the folder of a shipped policy; another word is a path. Raises `UsageError` for an unknown name."""
    if not is_name(word):
        return Path(word)
    known = names()
    if str(word) not in known:
        # Compared without the prefix, which would make all names similar.
        near = nearest(str(word).removeprefix(PREFIX), [name.removeprefix(PREFIX) for name in known])
        near = near.replace("mean '", f"mean '{PREFIX}")
        raise UsageError(f"there is no policy {word}{near}; these are shipped: {', '.join(known)}")
    return FOLDER / str(word).removeprefix(PREFIX)
