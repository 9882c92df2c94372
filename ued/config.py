"""One setting of a configuration: a dataclass field that carries its own help text.

Configurations are frozen dataclasses; the command line is derived from them (`experiments.arguments`). This module
needs no torch, so that `--help` stays quick. Read next: the configurations that are made of settings, such as `ppo`.
"""

from __future__ import annotations

from dataclasses import field
from typing import Any


def setting(default: Any, help: str) -> Any:
    """Give a dataclass field with this default and one line of help, as the command line shows it."""
    return field(default=default, metadata={"help": help})
