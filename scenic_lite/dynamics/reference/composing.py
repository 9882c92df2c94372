"""Compose blocks: threads whose `do` runs scenarios, several at once if it names several (spec section 11.8).

All that are named are set up and started one after the other in the order of the text, then each takes a step; from
then on one step each, until all have ended. `do A() until c` stops them when c is true; so does an `abort`. Read next:
`dynamics.reference.scenarios`.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import BehaviorCall
from scenic_lite.dynamics.reference.episode import Rejected
from scenic_lite.dynamics.reference.threads import End, Guarded, Step, Thread
from scenic_lite.evaluation.modular import scenario_frame

if TYPE_CHECKING:
    from scenic_lite.dynamics.reference.scenarios import Scenario


class ComposeThread(Thread):
    """The compose block of a scenario. A scenario with guards and no compose block waits, and checks its guards."""

    ended = False

    def _frame(self) -> Scope:
        return scenario_frame(self.episode.mode, self.call)

    def use(self, scope: Scope) -> None:
        """The names of a setup that has been executed already."""
        self.scope = scope

    @property
    def exists(self) -> bool:
        node = self.call.behavior.scenario
        return bool(node.compose or node.preconditions or node.invariants)

    def start(self, unchecked: bool = True) -> None:
        """Stand before the first statement; `unchecked`: the guards have not been checked in a setup."""
        if unchecked:
            self.check_guards()
        self._steps = self.run()

    def run(self) -> Iterator[Step]:
        if self.call.behavior.scenario.compose:
            yield from super().run()
            self.ended = True
            return
        while True:
            yield ()
            self.check_invariants()

    def close(self) -> None:
        """Give the block up."""
        if isinstance(self._steps, Generator):
            self._steps.close()
        self.ended = True

    def can_start(self, call: BehaviorCall) -> bool:
        try:
            ComposeThread(self.episode, replace(call, names={}), None, self.scenario).check_guards()
        except Guarded:
            return False
        return True

    def invoked(self, calls: list[BehaviorCall]) -> Iterator[Step]:
        """Run scenarios at the same time until all have ended."""
        subs: list[Scenario] = []
        try:
            for call in calls:
                subs.append(self.scenario.begin(call))
            while True:
                for sub in subs:
                    end = sub.step() if sub.running else None
                    if isinstance(end, End) and end.scope == "simulation":
                        yield end
                subs = [sub for sub in subs if sub.running]
                if not subs:
                    return
                yield ()
                subs = [sub for sub in subs if sub.running]
        except Rejected:
            subs = []  # the episode is over: what it leaves unsatisfied counts no more
            raise
        finally:
            self.scenario.finish(subs)
