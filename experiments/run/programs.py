"""Scenic programs on the command line: compiled with their settings, with warnings about likely errors.

Read next: `scenic_lite.loader`.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from regista.experiments.run.errors import UsageError
from regista.experiments.run.notes import warn

if TYPE_CHECKING:
    from regista.experiments.run.config import ProgramConfig
    from scenic_lite import Domain, Program


def load_program(path: Path, dialect: int | None, settings: ProgramConfig | None = None) -> Program:
    """Compile a football program and print its warnings. Raises `ScenicError` for an invalid one."""
    from regista.envs.football.scenic.domain import FOOTBALL

    return _load(path, FOOTBALL, dialect, settings)


def load_any_program(path: Path, dialect: int | None, settings: ProgramConfig) -> tuple[Program, bool]:
    """Compile a program of any domain; return it and whether it is football (uses the football library)."""
    from scenic_lite import ScenicError

    try:
        return _load(path, None, dialect, settings), False
    except ScenicError:
        return load_program(path, dialect, settings), True


def _load(path: Path, domain: Domain | None, dialect: int | None, settings: ProgramConfig | None) -> Program:
    from scenic_lite import load

    if settings is None:
        program = load(path, domain, dialect)
    else:
        program = load(path, domain, dialect, settings.scenario, read_params(settings.param), settings.model)
    for line in program.printed:
        print(f"{program.file} prints: {line}", file=sys.stderr)
    for warning in program.warnings:
        warn(f"warning: {warning}")
    return program


def read_params(texts: Sequence[str]) -> dict[str, object]:
    """Parse global parameters `name=value`: a number, True, False, None, a list of these, otherwise a string."""
    params: dict[str, object] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier():
            raise UsageError(f"--param must be name=value, got '{text}'")
        try:
            params[name] = ast.literal_eval(value)
        except (ValueError, SyntaxError):
            params[name] = value
    return params


def warn_of_play(program: Program) -> None:
    """Print warnings about players, a ball or settings that would stop a match or prevent all matches."""
    from regista.envs.football.scenic.lineup import Lineup, NotAMatchError
    from regista.envs.football.scenic.world import FOOTBALL_WORLD
    from scenic_lite import ScenicError
    from scenic_lite.dynamics.compiler.compile import compile_program

    try:
        lines: tuple[object, ...] = compile_program(program, FOOTBALL_WORLD).warnings
        Lineup(program)
    except (ScenicError, NotAMatchError) as error:
        lines = (f"no match can be played: {error}",)
    for line in lines:
        warn(f"warning: {line}")
