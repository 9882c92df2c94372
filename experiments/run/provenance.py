"""Provenance of results: machine, package versions, commit, command.

Read next: `run.folder`, whose config.json stores it.
"""

from __future__ import annotations

import os
import platform
import secrets
import shlex
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("regista", "numpy", "numba", "torch", "gymnasium", "rerun-sdk")


def about() -> dict[str, Any]:
    """Return the provenance of a new run: a unique id, time, command, commit, versions and machine."""
    return {
        "id": secrets.token_hex(6),
        "began": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command(),
        "commit": commit(),
        "versions": {"python": platform.python_version(), **versions(PACKAGES)},
        "machine": {"name": platform.node(), "system": platform.platform(), **hardware()},
    }


def processor_of(about: Mapping[str, Any]) -> str:
    """Return the processor that trained a run, or several joined by "; ", from its provenance; "" if unknown."""
    machine = about.get("machine")
    name = machine.get("processor") if isinstance(machine, Mapping) else None
    return name if isinstance(name, str) and name.isprintable() else ""


def continued(about: Mapping[str, Any]) -> dict[str, Any]:
    """Return the provenance of a run that this machine continues: with its processor, if that is another one."""
    before, here = processor_of(about), _processor()
    if not before or not here or before.split("; ")[-1] == here:
        return {**about}
    return {**about, "machine": {**about["machine"], "processor": f"{before}; {here}"}}


def command() -> str:
    """Return the running command line."""
    program = Path(sys.argv[0])
    name = program.parent.name if program.name == "__main__.py" else program.name
    return shlex.join([name, *sys.argv[1:]])


@cache
def commit() -> str:
    """Return the short hash of the checked-out commit; "" outside a checkout."""
    words = ["git", "-C", str(Path(__file__).parent), "rev-parse", "--short", "HEAD"]
    try:
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def versions(packages: tuple[str, ...]) -> dict[str, str]:
    """Return the versions of the installed packages among these."""
    installed = {}
    for name in packages:
        try:
            installed[name] = version(name)
        except PackageNotFoundError:
            continue
    return installed


def hardware() -> dict[str, Any]:
    """Return the processor and its number of cores."""
    return {"processor": _processor(), "cores": os.cpu_count()}


def _processor() -> str:
    try:
        with open("/proc/cpuinfo") as file:
            return next(line.partition(":")[2].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
