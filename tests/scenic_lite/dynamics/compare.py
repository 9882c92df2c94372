"""Playing one match twice, by the reference and by the machine, and telling what differs."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from regista.envs.toy_world import toy_world
from scenic_lite import ScenicError, load
from scenic_lite.core.types import Instance
from scenic_lite.dynamics.compiler.compile import compile_program
from scenic_lite.dynamics.machine.compiled import Compiled
from scenic_lite.values.geometry import Vector
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics.controller import CompiledController
from tests.scenic_lite.dynamics.toy_world import Controller, first_table, run

MINUS_ZERO = re.compile(r"-0(?![\d.])")
CLOSE = 1e-9  # relative: libraries differ in the last digit of some functions


def differences(
    text: str, seeds: range = range(3), steps: int = 12, dialect: int = 3, drift: float = 1.0, timestep: float = 1.0
) -> tuple[list[str], Compiled]:
    """Return what differs between the two in matches of a program in the toy world, and the code."""
    program = load(text, dialect=dialect)
    world = toy_world(timestep)
    compiled = compile_program(program, world)
    found = []
    for seed in seeds:
        theta = program.sample(1, np.random.default_rng(seed))[0][0]
        table = first_table(program, theta)
        expected = outcome(Reference(program, theta, world, seed), table, steps, drift)
        actual = outcome(CompiledController(compiled, theta, seed), table, steps, drift)
        if not alike(expected, actual):
            found.append(f"seed {seed}: {expected} but {actual}")
    return found, compiled


def outcome(controller: Controller, table: np.ndarray, steps: int, drift: float) -> tuple:
    """Return a trace as plain values; a fault by its line, but a loop without an action has no line of its own."""
    try:
        trace = run(table, controller, steps, drift)
    except ScenicError as error:
        assert error.place is not None, error
        return ("fault", "endless" if error.kind == "budget" else error.place.line)
    commands = tuple((each.actions, each.agents) for each in trace.commands)
    return (commands, trace.rewards, trace.ending, trace.rejected, recorded(controller.records))


def recorded(value: Any) -> Any:
    """Return records as tuples, with vectors and objects as what they show."""
    if isinstance(value, dict):
        return tuple((key, recorded(value[key])) for key in sorted(value))
    if isinstance(value, list | tuple):
        return tuple(map(recorded, value))
    if isinstance(value, Vector):
        return (value.x, value.y)
    return value.title() if isinstance(value, Instance) else value


def alike(a: Any, b: Any) -> bool:
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(alike, a, b))
    if isinstance(a, float) and isinstance(b, int | float):
        return abs(a - b) <= CLOSE * max(1.0, abs(a))
    if isinstance(a, str) and isinstance(b, str):  # x + 0 is x to the compiler, also if x is -0
        return MINUS_ZERO.sub("0", a) == MINUS_ZERO.sub("0", b)
    return a == b
