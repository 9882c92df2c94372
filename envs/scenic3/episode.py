"""A simulation that is driven step by step: Scenic's own loop runs to the end, ours waits for the agent's actions.

The simulation runs in a greenlet, which has its own stack. When Scenic requests actions from the agent's behavior, the
behavior switches back to the caller of `step`. The next `step` resumes it with an action. Scenic and its simulators
need no change. Scenic's state is global: a process plays one episode at a time.
Read next: `vector_env`, a process for each environment.
"""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import scenic.syntax.veneer as veneer
from greenlet import GreenletExit, greenlet
from gymnasium.spaces import Box
from scenic.core.dynamics.behaviors import Behavior
from scenic.core.scenarios import Scene
from scenic.core.sensors import GroundTruthSensor
from scenic.core.simulators import Simulation, Simulator, TerminationType

from regista.envs.scenic3.view import top_view

Outcome = tuple[Any, float, bool, bool, dict[str, Any]]  # the same as the result of `gymnasium.Env.step`


class Role(ABC):
    """The agent of a task: its observations, actions and rewards. Subclass it.

    Attributes:
        observation_space: a vector or an image.
        action_space: of any kind.
        max_steps: the time limit in steps, after which an episode is truncated; None: only the program ends episodes.
        timestep: the duration of a step in seconds; None: the default of the simulator.
    """

    observation_space: Box
    action_space: gymnasium.Space
    max_steps: int | None = 200
    timestep: float | None = None

    def render(self, simulation: Simulation) -> np.ndarray:
        """Return a picture for recordings: uint8 `[height, width, 3]`, always of the same size."""
        return top_view(simulation, self.agent(simulation.scene))

    def agent(self, scene: Scene) -> Any:
        """Return the object that the agent controls; the agent replaces its behavior in the program."""
        return scene.egoObject

    @abstractmethod
    def observe(self, simulation: Simulation) -> Any:
        """Return the agent's observation. Objects are in `simulation.objects`, in the order of the program."""

    @abstractmethod
    def act(self, action: Any, simulation: Simulation) -> Sequence[Any]:
        """Return the Scenic actions for an action of the agent, as in a behavior's `take` statement."""

    @abstractmethod
    def judge(self, simulation: Simulation) -> tuple[float, bool, bool | None]:
        """Return the reward of the last step, whether the episode ends, and whether it succeeds (None: unknown).

        It is also called once at the start of the episode, where the reward is ignored.
        """


class _Played(Behavior):
    """The agent's behavior: the caller of `step` supplies its actions."""

    episode: Episode

    def makeGenerator(self, agent: Any) -> Any:
        yield ()

    def checkPreconditions(self, *args: Any) -> None:
        """Do nothing: the behavior has no preconditions."""

    checkInvariants = checkPreconditions

    def _step(self) -> tuple[Any, ...]:
        action = self.episode.outside.switch()
        return tuple(self.episode.role.act(action, veneer.currentSimulation))


class Episode:
    """One simulation of a scene. Call `begin`, then `step` until it has ended, or `close` to stop early.

    Randomness inside the simulation, such as random values in behaviors, depends on `seed` alone. Random numbers that
    other code draws between steps have no effect on it.
    """

    def __init__(self, scene: Scene, simulator: Simulator, role: Role, seed: int) -> None:
        self.scene, self.simulator, self.role = scene, simulator, role
        self.outside = greenlet.getcurrent()
        self._inside = greenlet(self._simulate)
        random_state, numpy_state = random.Random(seed), np.random.RandomState(seed % 2**32)
        self._chance = random_state.getstate(), numpy_state.get_state()
        self._seen: Any = None
        self._simulation: Any = None
        self._judged: tuple[float, bool, bool | None] | None = None  # None: the step was rejected before its end
        agent = role.agent(scene)
        if agent is None:
            raise ValueError(
                "the program has no ego; override `Role.agent` to return the object that the agent controls"
            )
        agent.behavior = _Played()
        agent.behavior.episode = self
        agent.sensors = {**agent.sensors, "regista": GroundTruthSensor(self._look)}

    def begin(self) -> Any:
        """Run to the agent's first action; return the observation. Raises `ValueError` if the simulation ends first."""
        self._go_on()
        if self._inside.dead:
            raise ValueError(f"the simulation of {self.scene.egoObject} ended before its first step")
        return self._seen

    def step(self, action: Any) -> Outcome:
        """Apply an action and run until the next one. `info` has `success`, and the program's `ending` if any."""
        self._judged = None
        finished = self._go_on(action)
        info: dict[str, Any] = {}
        if self._judged is None:  # a requirement was violated; Scenic would discard this simulation
            return self._seen, 0.0, True, False, {"ending": "rejected", "success": False}
        reward, ended, success = self._judged
        cut = False
        if self._inside.dead:
            result = finished.result if finished is not None else None
            cut = result is not None and result.terminationType is TerminationType.timeLimit and not ended
            ended = not cut
            info["ending"] = "rejected" if result is None else result.terminationReason
            success = False if result is None else success
        elif ended:
            self.close()
        if success is not None:
            info["success"] = success
        return self._seen, float(reward), ended, cut, info

    def close(self) -> None:
        """End the simulation at any point."""
        if not self._inside.dead:
            self._inside.throw(GreenletExit)

    def render(self) -> np.ndarray:
        """Return a picture of the current state."""
        return self.role.render(self._simulation)

    def _simulate(self) -> Simulation | None:
        return self.simulator.simulate(self.scene, maxSteps=self.role.max_steps, timestep=self.role.timestep)

    def _look(self) -> None:
        """Observe and compute the reward: a sensor calls this in each step, including the last."""
        self._simulation = veneer.currentSimulation
        self._seen = self.role.observe(self._simulation)
        self._judged = self.role.judge(self._simulation)

    def _go_on(self, *action: Any) -> Any:
        """Run to the agent's next action or the end, with the simulation's own global random streams."""
        outside = random.getstate(), np.random.get_state()
        _set_streams(self._chance)
        try:
            return self._inside.switch(*action)
        finally:
            self._chance = random.getstate(), np.random.get_state()
            _set_streams(outside)


def _set_streams(states: tuple[Any, Any]) -> None:
    random.setstate(states[0])
    np.random.set_state(states[1])
