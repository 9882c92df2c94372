"""A simulation turned inside out: Scenic's simulators run to the end by themselves, here one waits for each action.

The simulation runs in a greenlet, a stack of its own. Where it is the agent's turn to act, a behavior that Scenic asks
for actions goes back to whoever called `step`, and goes on there with what the next `step` brings. Scenic itself, and
its simulators, need no change. Its state is global: a process plays one episode at a time.
Read next: `vector_env`, processes that play one each.
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

Outcome = tuple[Any, float, bool, bool, dict[str, Any]]  # as `gymnasium.Env.step` returns it


class Role(ABC):
    """What a program leaves open to make a task of it: what the agent sees, may do, and is paid for. Subclass it.

    Attributes:
        observation_space: a vector or an image.
        action_space: of any kind.
        max_steps: steps after which an episode is cut off; None: the program ends it.
        timestep: seconds of a step; None: the simulator's own.
    """

    observation_space: Box
    action_space: gymnasium.Space
    max_steps: int | None = 200
    timestep: float | None = None

    def render(self, simulation: Simulation) -> np.ndarray:
        """Return a picture of it for recordings: bytes `[height, width, 3]`, always of one size."""
        return top_view(simulation, self.agent(simulation.scene))

    def agent(self, scene: Scene) -> Any:
        """Return the object that acts; whatever behavior it has in the program is replaced."""
        return scene.egoObject

    @abstractmethod
    def observe(self, simulation: Simulation) -> Any:
        """Return what the agent sees now. Objects are in `simulation.objects`, in the order of the program."""

    @abstractmethod
    def act(self, action: Any, simulation: Simulation) -> Sequence[Any]:
        """Return the actions, as behaviors `take` them, that an action stands for."""

    @abstractmethod
    def judge(self, simulation: Simulation) -> tuple[float, bool, bool | None]:
        """Return the reward of the step that led here, whether the episode ends, and whether it then is a success.

        It is asked once at the start, too, where its reward counts for nothing; success None: not known.
        """


class _Played(Behavior):
    """The behavior of the agent: each step, its actions come from outside."""

    episode: Episode

    def makeGenerator(self, agent: Any) -> Any:
        yield ()

    def checkPreconditions(self, *args: Any) -> None:
        """Nothing must hold before it."""

    checkInvariants = checkPreconditions

    def _step(self) -> tuple[Any, ...]:
        action = self.episode.outside.switch()
        return tuple(self.episode.role.act(action, veneer.currentSimulation))


class Episode:
    """One simulation of a scene. `begin` it, `step` until it has ended, or `close` it before.

    Chance within it, such as behaviors that draw at random, comes from `seed` alone: whatever is drawn outside between
    steps changes nothing.
    """

    def __init__(self, scene: Scene, simulator: Simulator, role: Role, seed: int) -> None:
        self.scene, self.simulator, self.role = scene, simulator, role
        self.outside = greenlet.getcurrent()
        self._inside = greenlet(self._simulate)
        random_state, numpy_state = random.Random(seed), np.random.RandomState(seed % 2**32)
        self._chance = random_state.getstate(), numpy_state.get_state()
        self._seen: Any = None
        self._simulation: Any = None
        self._judged: tuple[float, bool, bool | None] | None = None  # None: a step that nobody saw the end of
        agent = role.agent(scene)
        if agent is None:
            raise ValueError("the program has no ego; name the object that acts by `Role.agent`")
        agent.behavior = _Played()
        agent.behavior.episode = self
        agent.sensors = {**agent.sensors, "regista": GroundTruthSensor(self._look)}

    def begin(self) -> Any:
        """Run up to the agent's first turn; return what it sees. Raises `ValueError` where it has none."""
        self._go_on()
        if self._inside.dead:
            raise ValueError(f"the simulation of {self.scene.egoObject} ended before its first step")
        return self._seen

    def step(self, action: Any) -> Outcome:
        """Act, and run up to the agent's next turn. `info` has `success`, and `ending` where the program ended it."""
        self._judged = None
        finished = self._go_on(action)
        info: dict[str, Any] = {}
        if self._judged is None:  # a requirement was broken: Scenic would not count this simulation at all
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
        """End the simulation, wherever it is."""
        if not self._inside.dead:
            self._inside.throw(GreenletExit)

    def render(self) -> np.ndarray:
        """Return a picture of this moment."""
        return self.role.render(self._simulation)

    def _simulate(self) -> Simulation | None:
        return self.simulator.simulate(self.scene, maxSteps=self.role.max_steps, timestep=self.role.timestep)

    def _look(self) -> None:
        """See and judge: Scenic asks each object's sensors in each step, in the last one, too."""
        self._simulation = veneer.currentSimulation
        self._seen = self.role.observe(self._simulation)
        self._judged = self.role.judge(self._simulation)

    def _go_on(self, *action: Any) -> Any:
        """Run until the agent's next turn, or the end, with the global streams that the simulation had left."""
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
