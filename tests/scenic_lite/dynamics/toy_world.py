"""One episode in the toy world, in which every object drifts up the y axis by the same distance in each step.

`run` plays it with any controller that has `act` and `watch`. Read next: `regista.envs.toy_world`;
`dynamics.reference.interpreter`.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from scenic_lite.core.world import Commands, Verdict
from scenic_lite.scene.program import Program
from tests.reference.interpreter import Reference


class Controller(Protocol):
    """What plays an episode: the reference, or a compiled program."""

    def act(self, world: np.ndarray, facts: np.ndarray) -> Commands: ...

    def watch(self, world: np.ndarray, facts: np.ndarray) -> Verdict: ...

    def finish(self) -> str | None: ...


class Trace(NamedTuple):
    """One episode.

    `commands`: of each step; `rewards`: of each watched step, one more than those in which the time ran out;
    `ending`: how it ended, "timeLimit: ..." if the steps were over; `rejected`: which requirement is broken, or None.
    """

    commands: tuple[Commands, ...]
    rewards: tuple[float, ...]
    ending: str
    rejected: str | None


def first_table(program: Program, theta: np.ndarray) -> np.ndarray:
    """Return the world table [O, 3] of the scene that theta [D] describes."""
    scenes = program.instantiate(np.asarray(theta, dtype=float)[None])
    return np.concatenate([scenes.positions[0], scenes.headings[0][:, None]], axis=1)


def run(table: np.ndarray, controller: Controller, steps: int, drift: float = 0.0) -> Trace:
    """Play at most `steps` steps from a world table [O, 3] on; raises ScenicError at a fault of the program."""
    commands: list[Commands] = []
    rewards: list[float] = []
    time, ending, rejected = 0, "", None
    while True:
        facts = np.array([float(time)])
        verdict = controller.watch(table, facts)
        rewards.append(verdict.reward)
        if verdict.rejected or verdict.terminated:
            ending, rejected = verdict.terminated or "", verdict.rejected
            break
        if time >= steps:
            ending, rejected = f"timeLimit: reached time limit ({steps} steps)", controller.finish()
            break
        table = with_new(table, controller)
        command = controller.act(table, facts)
        if command.rejected or command.terminated:
            ending, rejected = command.terminated or "", command.rejected
            break
        commands.append(command)
        table = table + np.array([0.0, drift, 0.0])
        time += 1
    return Trace(tuple(commands), tuple(rewards), ending, rejected)


def with_new(table: np.ndarray, controller: Controller) -> np.ndarray:
    """Return the table with rows for objects that scenarios have just made."""
    made = controller.objects[len(table) :] if isinstance(controller, Reference) else []
    rows = [[each.properties["position"].x, each.properties["position"].y, each.properties["heading"]] for each in made]
    return np.concatenate([table, np.array(rows)]) if rows else table
