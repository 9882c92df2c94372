"""Which behavior each object runs, and what all of them do in one step (spec section 11.1, number 5).

The objects run in the order of the scene, those made later after them. A behavior starts with the scenario that made
its object, or when an `override` gives it to it; one that was overridden stays where it is until it is given back. The
actions of an object are its `lastActions` at once, so that those after it see them (in Scenic 2 only from the next step
on). Read next: `dynamics.reference.scenarios`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenic_lite.core.types import BehaviorCall, Instance
from scenic_lite.dynamics.reference.episode import Episode
from scenic_lite.dynamics.reference.threads import End, Thread
from scenic_lite.values.graph import Value

if TYPE_CHECKING:
    from scenic_lite.dynamics.reference.scenarios import Scenario

Actions = list[tuple[Value, ...] | None]  # by object; None: it has no behavior


class Agents:
    """The threads of all objects that have or had a behavior."""

    def __init__(self, episode: Episode) -> None:
        self.episode = episode
        self._threads: dict[BehaviorCall, Thread] = {}
        self._homes: dict[Instance, Scenario] = {}

    def belongs(self, instance: Instance, scenario: Scenario) -> None:
        """`terminate` in a behavior of this object ends this scenario."""
        self._homes[instance] = scenario

    def assign(self, instance: Instance) -> Thread:
        """Start the present behavior of an object, unless it runs. Raises Rejected if its guards do not hold."""
        call = instance.properties["behavior"]
        thread = self._threads.get(call)
        if thread is not None and thread.agent is not instance:
            where = self.episode.program.error
            raise where("type", f"{call.behavior.name} already is the behavior of another object", call.place)
        if thread is None:
            thread = Thread(self.episode, call, instance, self._homes[instance])
            thread.start()
            self._threads[call] = thread
        return thread

    def step(self) -> tuple[Actions, End | None]:
        """What every object does; or the End of the whole episode, at which the others are not asked any more."""
        objects = list(self.episode.objects)
        at_once = self.episode.program.dialect == 3
        for each in objects if at_once else []:
            each.properties["lastActions"] = ()
        actions: Actions = []
        for each in objects:
            done, end = self._step_of(each)
            if end is not None:
                return actions, end
            actions.append(done)
            if at_once and done is not None:
                each.properties["lastActions"] = done
        for each, done in zip(objects, actions, strict=True) if not at_once else []:
            each.properties["lastActions"] = done or ()
        return actions, None

    def _step_of(self, instance: Instance) -> tuple[tuple[Value, ...] | None, End | None]:
        if instance.properties["behavior"] is None:
            return None, None
        step = self.assign(instance).step()
        if not isinstance(step, End):
            return step, None
        home = self._homes[instance]
        if step.scope == "scenario" and home.running:
            home.stop()
        if step.scope == "simulation" or home.parent is None:
            return None, step
        return (), None
