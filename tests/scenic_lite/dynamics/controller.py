"""One match of a compiled program, driven from Python with the calls of `Reference`: the machine for a batch of one."""

from __future__ import annotations

from typing import Any

import numpy as np

from regista.kernels.rng import streams
from scenic_lite.core.world import Commands, Verdict
from scenic_lite.dynamics.machine.bytecode import NO_COMMAND, REJECTED, TERMINATED
from scenic_lite.dynamics.machine.compiled import Compiled
from scenic_lite.dynamics.machine.vm import end, over, run_behaviors, run_watchers
from scenic_lite.values.graph import RandomExpr, Value

RNG_DTYPE = np.dtype([("random", "u8")])


class CompiledController:
    """One match of a compiled program; the same calls as `Reference`."""

    def __init__(self, compiled: Compiled, theta: np.ndarray, seed: int = 0) -> None:
        self.compiled = compiled
        theta = np.asarray(theta, dtype=float)[None]
        self.registers = compiled.registers(theta)[0]
        self.rng = np.zeros(1, dtype=RNG_DTYPE).view(np.recarray)[0]
        self.rng.random = streams([seed])[0]
        self._scene: dict[RandomExpr, Value] = dict(compiled.program.row(theta[0]))
        self.commands = np.full(len(compiled.program.objects), NO_COMMAND)
        self.records: dict[str, Any] = {}  # as of `Reference`

    def act(self, world: np.ndarray, facts: np.ndarray) -> Commands:
        """Do as `Reference.act`."""
        self._see(world, facts)
        with np.errstate(all="ignore"):
            run_behaviors(self.compiled.code, self.registers, self.commands, self.rng)
        self._check()
        self._note("initial", "final")
        actions = tuple(self._actions(number) for number in self.commands)
        return Commands(actions, self._agents(), self._terminated(), self._rejected())

    def _agents(self) -> tuple[int, ...]:
        """Return the objects that have a behavior now."""
        having = {moved for moved in self.compiled.threads if moved >= 0}
        for number, register, at_first in self.compiled.overridden:
            now = self.registers[register]
            if now < 0 or (now == 0 and not at_first):
                having.remove(number)
        return tuple(sorted(having))

    def _actions(self, number: float) -> tuple[Value, ...]:
        if number == NO_COMMAND:
            return ()
        if not self.compiled.commands:
            return (float(number),)
        actions = self.compiled.commands[int(number)]
        return tuple(self.compiled.plain(action, self.registers, self._scene) for action in actions)

    def watch(self, world: np.ndarray, facts: np.ndarray) -> Verdict:
        """Do as `Reference.watch`."""
        self._see(world, facts)
        running = not over(self.registers)
        with np.errstate(all="ignore"):
            reward = run_watchers(self.compiled.code, self.registers, self.rng)
        self._check()
        if running:
            self._note("initial", "each", "final")
        return Verdict(float(reward), self._terminated(), self._rejected())

    def finish(self) -> str | None:
        """End the match because its time is over; return which requirement that leaves unsatisfied, if any."""
        if not over(self.registers):
            end(self.compiled.code, self.registers, self.commands, self.rng)
            self._note("final")
        return self._rejected()

    def _note(self, *kinds: str) -> None:
        """Take over what has just been recorded."""
        time = int(self.registers[self.compiled.code.clock]) if self.compiled.records else 0
        for record in self.compiled.records:
            taken = int(self.registers[record.taken])
            if record.when not in kinds or taken != time:
                continue
            value = self.compiled.plain(record.value, self.registers, self._scene)
            if record.when == "each":
                self.records.setdefault(record.name, []).append((time, value))
            else:
                self.records[record.name] = value

    def _see(self, world: np.ndarray, facts: np.ndarray) -> None:
        code = self.compiled.code
        self.registers[code.world_base : code.world_base + world.size] = world.ravel()
        self.registers[code.fact_base : code.fact_base + len(facts)] = facts

    def _check(self) -> None:
        fault = self.compiled.fault(self.registers)
        if fault is not None:
            raise fault

    def _terminated(self) -> str | None:
        number = int(self.registers[TERMINATED])
        return self.compiled.end_reasons[number - 1] if number and not self._rejected() else None

    def _rejected(self) -> str | None:
        number = int(self.registers[REJECTED])
        return self.compiled.rejections[number - 1] if number else None
