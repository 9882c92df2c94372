"""Football programs as a task: training environments, test scenes, pictures of levels, and baseline policies.

Read next: `ued.core.task`; `football.vector_env`, the environments.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import DIRECTION_RIGHT, SHOT
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.vector_env import FootballVectorEnv
from regista.envs.football.view.render import FootballPainter
from scenic_lite import Program
from ued.core.baselines import ScriptedPolicy, UniformPolicy, Untrained
from ued.core.task import Task

Programs = Mapping[str, Program | str | Path]


def football_task(
    program: Program,
    tests: Programs | None = None,
    held_out: Programs | None = None,
    config: FootballConfig = FootballConfig(),  # noqa: B008 (frozen)
    make: Callable[..., FootballVectorEnv] = FootballVectorEnv,
) -> Task:
    """Return the task of a training program and its test programs by name.

    Args:
        program: the training program.
        tests: programs of test scenes by name, with the same number of players; loaded on first use.
        held_out: the same, for final tables only.
        config: observations, control and rewards of the agents.
        make: called as `make(program, num_envs, config=config)`.

    Raises `NotAMatchError` for a program that describes no match.
    """
    lineup = Lineup(program, str(config.control), str(config.right_control), config.engine_spread)
    ours = config.engine == "regista"  # a second set of GRF matches for every scene would start its processes again

    def environments(programs: Programs | None) -> dict[str, Any]:
        return {name: partial(make, test, config=config) for name, test in (programs or {}).items()}

    return Task(
        partial(make, program, config=config),
        environments(tests),
        painter=lambda upomdp: FootballPainter(upomdp.lineup),  # type: ignore[attr-defined]
        held_out=environments(held_out),
        baselines={"shoot": _shoot, "random": _random} | ({"built-in": _built_in} if ours else {}),
        success_word="success" if lineup.config.defending else "goals",
    )


class ShootPolicy(Untrained):
    """Shoot at once: alternate between running at the goal and shooting, since releasing the action kicks."""

    def __init__(self, agents: tuple[int, ...]) -> None:
        self.shot, self.agents = False, agents

    def play(self, observation: np.ndarray, generator: Any, greedy: bool = False, memory: Any = None) -> np.ndarray:
        """Return one action for each row of `observation` `[N, size]`; with several agents one for each, `[N, A]`."""
        self.shot = not self.shot
        return np.full((len(observation), *self.agents), SHOT if self.shot else DIRECTION_RIGHT)


def _agents(upomdp: Any) -> tuple[int, ...]:
    return () if upomdp.num_agents == 1 else (upomdp.num_agents,)


def _shoot(upomdp: Any) -> ShootPolicy:
    return ShootPolicy(_agents(upomdp))


def _built_in(upomdp: Any) -> ScriptedPolicy:
    """Return the policy in which the program's behaviors, or the built-in AI, play the agents' players."""
    return ScriptedPolicy(_agents(upomdp))


def _random(upomdp: Any) -> UniformPolicy:
    return UniformPolicy(upomdp.agent_action_space, _agents(upomdp))
