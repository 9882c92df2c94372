"""Where numbers come from: the machine, versions of what computed them, the commit, the command.

Read next: `run.folder`, whose config.json holds it.
"""

from __future__ import annotations

import os
import platform
import secrets
import shlex
import subprocess
import sys
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("regista", "numpy", "numba", "torch", "gymnasium", "rerun-sdk")


def about() -> dict[str, Any]:
    """Return what is kept of the beginning of a run: an id of its own, when, how, by what and where it began."""
    return {
        "id": secrets.token_hex(6),
        "began": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command(),
        "commit": commit(),
        "versions": {"python": platform.python_version(), **versions(PACKAGES)},
        "machine": {"name": platform.node(), "system": platform.platform(), **hardware()},
    }


def command() -> str:
    """Return the command that is running, as it was typed."""
    program = Path(sys.argv[0])
    name = program.parent.name if program.name == "__main__.py" else program.name
    return shlex.join([name, *sys.argv[1:]])


@cache
def commit() -> str:
    """Return the commit that is running, short; "" outside a checkout."""
    words = ["git", "-C", str(Path(__file__).parent), "rev-parse", "--short", "HEAD"]
    try:
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def versions(packages: tuple[str, ...]) -> dict[str, str]:
    """Return the versions of those of these packages that are installed."""
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
