"""Threads: a behavior, a monitor or the compose block of a scenario that is running, up to where it lets time pass.

A thread is a Python generator over the statements of its body (`dynamics.reference.statements`). Each time it is
resumed it runs until it gives its next `Step`: the actions of this step, () for `wait`, or the `End` that a `terminate`
asks for. All else is part of the same instant: conditions, assignments, calls, draws, the start and the end of
sub-behaviors. Arguments are values when the behavior is called, the names of the body are looked up when they are read.
The guards of a thread see its own variables.

`Agents` says which behavior each object runs, and what all of them do in one step. The objects run in the order of the
scene, those made later after them. A behavior starts with the scenario that made its object, or when an `override`
gives it to it; one that was overridden stays where it is until it is given back. The actions of an object are its
`lastActions` at once, so that those after it see them (in Scenic 2 only from the next step on).
Read next: `dynamics.reference.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import BehaviorCall, Instance
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.calls import Return, seen_from
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value
from tests.reference.episode import Episode, Rejected

DEEPEST = 40  # sub-behaviors inside each other
PASSING_TIME = (*nodes.SUSPENDING, nodes.Abort, nodes.TryInterrupt)


class End(NamedTuple):
    """What `terminate` gives instead of actions: the end of a scenario, or of the simulation."""

    scope: str  # "scenario" or "simulation"
    statement: str  # "terminate" or "terminate simulation"
    line: int

    def reason(self) -> str:
        return f'"{self.statement}" executed on line {self.line}'


Step = tuple[Value, ...] | End


class Guarded(Rejected):
    """A precondition or invariant does not hold."""


class Thread:
    """One running behavior, monitor or compose block; `agent` is the object that a behavior moves."""

    def __init__(self, episode: Episode, call: BehaviorCall, agent: Instance | None = None) -> None:
        self.episode, self.call, self.agent = episode, call, agent
        self.depth = 0
        self.scope = self._scope()
        self._steps: Iterator[Step] | None = None

    def _scope(self) -> Scope:
        """Return the names of the body: the arguments, `self`, and its variables, which hide those outside."""
        behavior = self.call.behavior
        names = {**self.call.arguments, "self": self.agent}
        scope = Scope.inside(self.episode.mode, behavior.scope, names)
        scope.assigned = behavior.assigned
        return scope

    def start(self) -> None:
        """Check the guards, and stand before the first statement. Raises Rejected."""
        self.check_guards()
        self._steps = self.run()

    def step(self) -> Step:
        """Return what the thread does in this step; () once it has ended."""
        assert self._steps is not None, "a thread that was not started"
        self.episode.rested()
        return next(self._steps, ())

    def run(self) -> Iterator[Step]:
        """Run the whole body."""
        node = self.call.behavior.node
        try:
            yield from self.block(node.compose if isinstance(node, nodes.Scenario) else node.body)
        except Return:
            return
        except ScenicError as error:
            raise self.seen_from_call(error) from None

    def seen_from_call(self, error: ScenicError) -> ScenicError:
        """Return an error of this thread, as whoever wrote its call sees it."""
        return seen_from(self.scope.state, self.call.behavior, self.call.place, error)

    def block(self, statements: Sequence[ast.stmt]) -> Iterator[Step]:
        """Run some statements, in order. Those in which time cannot pass are executed as in a function."""
        for node in statements:
            handler = self.episode.suspending.get(type(node)) if lets_time_pass(node) else None
            try:
                if handler is None:
                    self.scope.run([node])
                else:
                    yield from handler(self, node)
                    if isinstance(node, nodes.SUSPENDING):
                        self.check_invariants()
            except ScenicError as error:
                raise self.scope.placed(error, node) from None

    def check_guards(self) -> None:
        """Check preconditions, then invariants."""
        self._check("precondition", self.call.behavior.node.preconditions)
        self.check_invariants()

    def check_invariants(self) -> None:
        """Check invariants, whenever this thread goes on after time has passed."""
        self._check("invariant", self.call.behavior.node.invariants)

    def _check(self, word: str, conditions: list[ast.expr]) -> None:
        """Raise Guarded where a guard does not hold; one that has nothing to draw from does not."""
        for condition in conditions:
            try:
                holds = self.scope.truth(condition)
            except ScenicError as error:
                if error.kind != "rejection":
                    raise
                holds = False
            if not holds:
                raise Guarded(f"violated {word} of {self.call.behavior.name} on line {condition.lineno}")

    def inner(self, call: BehaviorCall) -> Thread:
        """Return the thread of a sub-behavior of the same agent."""
        return Thread(self.episode, call, self.agent)

    def can_start(self, call: BehaviorCall) -> bool:
        """Return whether the guards of what may be chosen hold now."""
        try:
            self.inner(call).check_guards()
        except Guarded:
            return False
        return True

    def invoked(self, calls: list[BehaviorCall]) -> Iterator[Step]:
        """Run a sub-behavior of the same agent in place; the checker has seen that it is only one."""
        thread = self.inner(calls[0])
        thread.depth = self.depth + 1
        if thread.depth > DEEPEST:
            raise ScenicError("budget", f"behaviors call each other more than {DEEPEST} deep")
        thread.check_guards()
        yield from thread.run()


@lru_cache(maxsize=4096)
def lets_time_pass(node: ast.stmt) -> bool:
    """Return whether a statement is or contains one that suspends its thread or acts on its blocks."""
    return any(isinstance(part, PASSING_TIME) for part in nodes.walk_own(node))


# ------------------------------------------------------------ the objects

Actions = list[tuple[Value, ...] | None]  # by object; None: it has no behavior


class Agents:
    """The threads of all objects that have or had a behavior."""

    def __init__(self, episode: Episode) -> None:
        self.episode = episode
        self._threads: dict[BehaviorCall, Thread] = {}
        self._on_end: dict[Instance, Callable[[End], End | None]] = {}

    def belongs(self, instance: Instance, on_end: Callable[[End], End | None]) -> None:
        """Say what `terminate` in a behavior of this object ends; what that returns ends the episode."""
        self._on_end[instance] = on_end

    def assign(self, instance: Instance) -> Thread:
        """Start the present behavior of an object, unless it runs. Raises Rejected if its guards do not hold."""
        call = instance.properties["behavior"]
        thread = self._threads.get(call)
        if thread is not None and thread.agent is not instance:
            where = self.episode.program.error
            raise where("type", f"{call.behavior.name} already is the behavior of another object", call.place)
        if thread is None:
            thread = Thread(self.episode, call, instance)
            thread.start()
            self._threads[call] = thread
        return thread

    def step(self) -> tuple[Actions, End | None]:
        """Return what every object does; or the End of the episode, at which the others are not asked any more."""
        objects = list(self.episode.objects)
        at_once = self.episode.program.dialect == 3
        for instance in objects if at_once else []:
            instance.properties["lastActions"] = ()
        actions: Actions = []
        for instance in objects:
            done, end = self._step_of(instance)
            if end is not None:
                return actions, end
            actions.append(done)
            if at_once:
                instance.properties["lastActions"] = done or ()
        for instance, done in zip(objects, actions, strict=True) if not at_once else []:
            instance.properties["lastActions"] = done or ()
        return actions, None

    def _step_of(self, instance: Instance) -> tuple[tuple[Value, ...] | None, End | None]:
        if instance.properties["behavior"] is None:
            return None, None
        step = self.assign(instance).step()
        if not isinstance(step, End):
            return step, None
        end = self._on_end[instance](step)
        return (None, end) if end is not None else ((), None)
