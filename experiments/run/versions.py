"""Simulator version of a run, and its comparison with the version of this code.

Run folders, checkpoints, recordings, demonstrations and rows of tables store the version. Python tasks and Google
Research Football have none, since they do not use the simulator. Folders without a number belong to an unnumbered
simulator. Read next: `envs.football.version`, the number; `run.folder`, which stores it.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from regista.envs.football.version import SIMULATOR_VERSION, UNNUMBERED, simulator_name, version_on
from regista.experiments.run.errors import CommandError
from regista.experiments.run.notes import warn

KEY = "simulator"  # key of the version in files
NO_SIMULATOR = "none"  # in tables: for a Python task, or for GRF


def present_version(config: Any) -> int | None:
    """Return the simulator version of this code for a run's settings; None for a Python task and for GRF."""
    env = getattr(config, "env", None)
    return None if env is None else version_on(env.engine)


def saved_version(config: Any, saved: Mapping[str, Any], where: str) -> int | None:
    """Return the simulator version in `saved` data with these settings; `where` names their file.

    Raises `CommandError` for an invalid version.
    """
    if present_version(config) is None:
        return None
    version = saved.get(KEY, UNNUMBERED)
    if isinstance(version, str):  # a digest of source files, from an unnumbered simulator
        return UNNUMBERED
    if type(version) is not int or version < 0:
        raise CommandError(f"{where}: '{KEY}' must be an integer, 0 or larger, got {version!r}")
    return version


def stamp(config: Any) -> dict[str, int]:
    """Return the version entry of a file, empty without a simulator."""
    version = present_version(config)
    return {} if version is None else {KEY: version}


def spelled(version: int | None) -> str:
    """Format a version for tables."""
    return NO_SIMULATOR if version is None else str(version)


def check_present(version: int | None, what: str, refused: str) -> None:
    """Raise `CommandError` if a version, unless None, differs from the present one.

    The message is "`what` VERSION; on version PRESENT `refused`", for example with what = "x was trained on" and
    refused = "it cannot be resumed".
    """
    if version not in (None, SIMULATOR_VERSION):
        raise CommandError(f"{what} {simulator_name(version)}; on version {SIMULATOR_VERSION} {refused}")


def check_alike(trained: Mapping[Path, int | None], verb: str = "evaluate") -> None:
    """Raise `CommandError` if runs in one table, given by path, have different versions; None is ignored."""
    found = {version: path for path, version in trained.items() if version is not None}
    if len(found) > 1:
        named = ", ".join(f"{path} on {simulator_name(version)}" for version, path in found.items())
        raise CommandError(f"these runs were trained on different simulators: {named}; {verb} them separately")


def warn_of_age(path: Path, version: int | None) -> None:
    """Warn if a run was trained on another version than the present one."""
    if version not in (None, SIMULATOR_VERSION):
        warn(f"warning: {path} was trained on {simulator_name(version)}; this is version {SIMULATOR_VERSION}")
