"""A program's behaviors, compiled for its matches: what they start from, and what is said where they fail.

Read next: `script`, how a match is played with them; `scenic_lite.dynamics.compiler.compiler`.
"""

from __future__ import annotations

import numpy as np

from envs.football.batch import Batch
from envs.football.constants import BAD_ACTION, BUILTIN_AI, PROGRAM_FAULT
from envs.football.world import FOOTBALL_WORLD
from scenic_lite import Program, ScenicError
from scenic_lite.dynamics.bytecode import NO_COMMAND
from scenic_lite.dynamics.compiler.compiler import compile_program


class Staging:
    """How the behaviors and monitors of a program take part in its matches.

    Attributes:
        code: for kernels.
        live: whether there is anything to run.
        num_registers: R, the numbers that they remember in each match.

    Raises ScenicError for a behavior that cannot be compiled.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.compiled = compile_program(program, FOOTBALL_WORLD)
        self.code = self.compiled.code
        watched = bool(program.terminations or program.temporal)
        self.live = watched or self.code.behaviors + self.code.monitors > 0
        self.num_registers = self.code.register_count

    def registers(self, theta: np.ndarray) -> np.ndarray:
        """What the behaviors remember at the start of an episode on θ `[N, D]`: `[N, R]`."""
        return self.compiled.registers(theta)

    def error(self, batch: Batch, index: int, levels: np.ndarray) -> Exception:
        """The error for a match that cannot go on: the program's line, the match's number and the step."""
        match = batch.matches[index]
        where = f"match {index} of {len(batch.matches)}, step {match['step']}; its level: {levels[index]}"
        if match["fault"] not in (PROGRAM_FAULT, BAD_ACTION):
            return FloatingPointError(f"impossible state (fault {match['fault']}) in {where}")
        error = self._bad_action(batch.commands[index]) if match["fault"] == BAD_ACTION else self._fault(batch, index)
        error.notes = (*error.notes, f"    in {where}")
        return error

    def _fault(self, batch: Batch, index: int) -> ScenicError:
        error = self.compiled.fault(batch.registers[index])
        assert error is not None
        return error

    def _bad_action(self, commands: np.ndarray) -> ScenicError:
        """The error for what a behavior took and is no action."""
        wrong = ~np.isin(commands, [NO_COMMAND, *range(BUILTIN_AI + 1)])
        which = int(np.flatnonzero(wrong)[0])
        info = self.program.objects[which]
        message = f"{info.name or info.class_name} takes an action that does not exist: {commands[which]:g}"
        assert info.behavior_place is not None
        return self.program.error("value", message, info.behavior_place, f"actions are 0 to {BUILTIN_AI}")
