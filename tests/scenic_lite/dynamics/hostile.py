"""Code and registers with a number changed: refused before they run, or run without a step beside the registers.

python -m tests.scenic_lite.dynamics.hostile COUNT SEED
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from functools import cache

import numpy as np

from regista.envs.toy_world import FACTS, FIELDS, toy_world
from scenic_lite import load
from scenic_lite.dynamics.compiler.compile import compile_program
from scenic_lite.dynamics.machine.bytecode import Code
from scenic_lite.dynamics.machine.compiled import Compiled
from scenic_lite.dynamics.machine.verify import CodeError, verify
from scenic_lite.dynamics.machine.vm import run_behaviors, run_watchers
from tests.scenic_lite.dynamics import feature_programs
from tests.scenic_lite.dynamics.controller import RNG_DTYPE
from tests.scenic_lite.dynamics.generated import program as generated

MARGIN, CANARY = 4096, 7.25  # registers before and after those of the program, and what stands there
STEPS = 4
SECONDS = 2.0  # of processor time, at most, for one attempt
NUMBERS = np.array([np.nan, np.inf, -np.inf, -1.0, 1e308, -1e19, 1e9, 2.0**31, 2.0**63, 0.5, -0.5, 3.0, 7.0, 100.0])
REFUSED, RAN = "refused", "ran"


@dataclass(frozen=True)
class Target:
    """A compiled program, and registers with which it has run some steps."""

    compiled: Compiled
    objects: int
    cells: int
    registers: np.ndarray  # [R]

    @classmethod
    def of(cls, text: str) -> Target:
        """Compile a program of the toy world."""
        program = load(text)
        compiled = compile_program(program, toy_world())
        objects = len(program.objects)
        target = cls(
            compiled, objects, objects * len(FIELDS) + len(FACTS), compiled.registers(np.zeros((1, program.dim)))[0]
        )
        target.run(compiled.code, target.registers)
        return target

    def run(self, code: Code, registers: np.ndarray) -> None:
        """Run some steps with these registers. Raises AssertionError where anything beside them was written."""
        room = np.full(len(registers) + 2 * MARGIN, CANARY)
        inside, commands = room[MARGIN:-MARGIN], np.full(self.objects + 2 * MARGIN, CANARY)
        inside[:] = registers
        rng = np.ones(1, RNG_DTYPE).view(np.recarray)[0]
        for step in range(STEPS):
            inside[code.clock] = step
            run_behaviors(code, inside, commands[MARGIN:-MARGIN], rng)
            run_watchers(code, inside, rng)
        registers[:] = inside
        for array in (room, commands):
            assert (array[:MARGIN] == CANARY).all() and (array[-MARGIN:] == CANARY).all(), (
                "written beside the registers"
            )

    def attempt(self, rng: np.random.Generator) -> str:
        """Change one number of the code, or some registers, and say what became of it."""
        code, registers = self.compiled.code, self.registers.copy()
        began = time.process_time()
        if rng.random() < 0.5:
            code = self._other_code(rng)
        else:
            where = rng.integers(len(registers), size=1 + rng.integers(3))
            registers[where] = rng.choice(NUMBERS, len(where)) if rng.random() < 0.7 else rng.normal(0, 30, len(where))
        try:
            verify(code, self.objects, self.cells)
        except CodeError:
            return REFUSED
        self.run(code, registers)
        assert time.process_time() - began < SECONDS, "took too long"
        return RAN

    def _other_code(self, rng: np.random.Generator) -> Code:
        code, name = (
            self.compiled.code,
            str(rng.choice(["rows", "rows", "rows", "lists", "threads", "clock", "world_base"])),
        )
        if name in ("clock", "world_base"):
            return code._replace(**{name: int(rng.integers(-3, 2 * code.register_count))})
        array = getattr(code, name).copy()
        least = -3 if name == "threads" else 0
        most = int(rng.choice([8, 60, len(code.rows) + 3, code.register_count + 3, 2**31 - 1]))
        array.reshape(-1)[rng.integers(array.size)] = rng.integers(least, most)
        return code._replace(**{name: array})


@cache
def known() -> tuple[Target, ...]:
    """Return programs of every kind of row."""
    texts = [feature_programs.program(name) for name in feature_programs.BODIES]
    return tuple(Target.of(text) for text in [*texts, feature_programs.MIXED])


def attack(count: int, seed: int) -> dict[str, int]:
    """Make so many attempts; return how many were refused and how many ran."""
    rng, counts, programs = np.random.default_rng(seed), {REFUSED: 0, RAN: 0}, [*known()]
    programs += [Target.of(generated(4 * seed + k)) for k in range(4)]
    for k in range(count):
        counts[programs[k % len(programs)].attempt(rng)] += 1
    return counts


if __name__ == "__main__":
    print(attack(int(sys.argv[1]), int(sys.argv[2])))
