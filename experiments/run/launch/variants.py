"""Rows of a comparison: methods with the settings of all runs, and named variants with their own settings.

    regista compare maze --methods dr --variants "slow: --learning-rate 3e-4" "few: --method accel --accel.num-edits 3"

Read next: `run.launch.seeds`, which makes their runs.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import group
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import ROW_NAME
from ued.methods import METHODS

FORM = '"NAME: FLAGS", as in "slow: --learning-rate 3e-4"'


class Variant(NamedTuple):
    """A row of a comparison: its name in tables and folders, and the settings of its runs except their seeds."""

    name: str
    config: Any


@dataclass(frozen=True)
class Flags:
    """The flags of a variant."""

    train: Any = group(TrainConfig, "each run", without=("minigame", "seed"))


def rows_of(methods: Sequence[str], variants: Sequence[str], settings: Any) -> list[Variant]:
    """Return the rows of a comparison: one for each method, and one for each variant `NAME: FLAGS`.

    Without `--method` among its flags, a variant uses the first method, or DR if there is none.
    Raises UsageError for an invalid variant, such as one with settings of another method, for a name that occurs twice,
    and for another environment.
    """
    rows = [Variant(method, replace(settings, method=method)) for method in methods]
    base = rows[0].config if rows else replace(settings, method="dr")
    rows += [_read(text, base) for text in variants]
    names = [row.name for row in rows]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise UsageError(f"two rows of the comparison are called {twice!r}; give them different names")
    return rows


def _read(text: str, base: Any) -> Variant:
    name, colon, flags = (part.strip() for part in text.partition(":"))
    if not colon or not re.fullmatch(ROW_NAME, name):
        raise UsageError(f"--variants {text!r} is not {FORM}; names have letters, digits, and . _ + -")
    try:
        typed = arguments.typed_settings(Flags(train=base), shlex.split(flags), "compare", "")
        config = arguments.replace_paths(Flags(train=base), typed).train
        build.find_method(config.method)
        build.check_used((name.removeprefix("train.") for name in typed), [config.method])
        build.find_device(config.device)
    except (UsageError, ValueError) as error:  # shlex rejects unclosed quotes
        raise UsageError(f"--variants {text!r}: {error}") from error
    if name in METHODS and name != config.method:
        raise UsageError(f"--variants {text!r}: {name} is the name of a method; choose another one, or --method {name}")
    if getattr(config, "env", None) != getattr(base, "env", None):
        raise UsageError(f"--variants {text!r}: variants of one comparison share the environment and its settings")
    return Variant(name, config)
