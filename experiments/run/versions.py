"""On which version of the football simulator a run plays, and whether that is the version of this code.

What a run leaves carries the number: its folder, checkpoint, recording, demonstrations and rows of tables. A task of
one's own and Google Research Football have none: what they play does not depend on it. Old folders without a number
are of an unnumbered simulator. Read next: `envs.football.version`, the number; `run.folder`, which keeps it.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from regista.envs.football.version import SIMULATOR_VERSION, UNNUMBERED, simulator_name, version_on
from regista.experiments.run.errors import CommandError
from regista.experiments.run.notes import warn

KEY = "simulator"  # under which files carry the version
NO_SIMULATOR = "none"  # in tables: of a task of one's own, or of the real engine


def present_version(config: Any) -> int | None:
    """Return the version on which settings are played by this code; None for a task and for the real engine."""
    env = getattr(config, "env", None)
    return None if env is None else version_on(env.engine)


def saved_version(config: Any, kept: Mapping[str, Any], where: str) -> int | None:
    """Return the version on which what has these settings was played, by what is `kept` of it, in the file `where`.

    Raises `CommandError` for what is no version.
    """
    if present_version(config) is None:
        return None
    version = kept.get(KEY, UNNUMBERED)
    if isinstance(version, str):  # a digest of source files, from before version 1
        return UNNUMBERED
    if type(version) is not int or version < 0:
        raise CommandError(f"{where}: '{KEY}' must be a whole number from 0 on, got {version!r}")
    return version


def stamp(config: Any) -> dict[str, int]:
    """Return what a file carries of the version, an entry or nothing."""
    version = present_version(config)
    return {} if version is None else {KEY: version}


def spelled(version: int | None) -> str:
    """Return a version as tables have it."""
    return NO_SIMULATOR if version is None else str(version)


def check_present(version: int | None, what: str, refused: str) -> None:
    """Raise `CommandError` unless a version is that of this code.

    The sentence is "`what` that version; on this version `refused`": "x was trained on", "it cannot be resumed".
    """
    if version not in (None, SIMULATOR_VERSION):
        raise CommandError(f"{what} {simulator_name(version)}; on version {SIMULATOR_VERSION} {refused}")


def check_alike(trained: Mapping[Path, int | None]) -> None:
    """Raise `CommandError` where runs that would share a table were trained on different versions, given by path."""
    found = {version: path for path, version in trained.items() if version is not None}
    if len(found) > 1:
        named = ", ".join(f"{path} on {simulator_name(version)}" for version, path in found.items())
        raise CommandError(f"these runs were trained on different simulators: {named}; evaluate them apart")


def warn_of_age(path: Path, version: int | None) -> None:
    """Warn where a run was trained on another version than that of this code."""
    if version not in (None, SIMULATOR_VERSION):
        warn(f"warning: {path} was trained on {simulator_name(version)}; this is version {SIMULATOR_VERSION}")
