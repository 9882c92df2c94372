"""Threads: a behavior, a monitor or the compose block of a scenario that is running, up to where it lets time pass.

A thread is a Python generator over the statements of its body (`execution`). Each time it is resumed it runs until it
gives its next `Step`: the actions of this step, () for `wait`, or the `End` that a `terminate` asks for. All else is
part of the same instant: conditions, assignments, calls, draws, the start and the end of sub-behaviors.

Arguments are values when the behavior is called, the names of the body are looked up when they are read. The guards of
a thread see its own variables. Read next: `dynamics.reference.suspending_statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import BehaviorCall, Instance
from scenic_lite.dynamics.reference.episode import Episode, Rejected
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.calls import Return
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value

if TYPE_CHECKING:
    from scenic_lite.dynamics.reference.scenarios import Scenario

DEEPEST = 40  # sub-behaviors inside each other


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
    """One running behavior, monitor or compose block; `scenario` is the one that it belongs to."""

    def __init__(self, episode: Episode, call: BehaviorCall, agent: Instance | None, scenario: Scenario) -> None:
        self.episode, self.call, self.agent, self.scenario = episode, call, agent, scenario
        self.depth = 0
        self.scope = self._frame()
        self._steps: Iterator[Step] | None = None

    def _frame(self) -> Scope:
        """The names of the body: the arguments, `self`, and its variables, which hide those outside from the start."""
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
        """What the thread does in this step; () once it has ended."""
        assert self._steps is not None, "a thread that was not started"
        self.episode.rested()
        return next(self._steps, ())

    def run(self) -> Iterator[Step]:
        """The whole body."""
        node = self.call.behavior.node
        try:
            yield from self.block(node.compose if isinstance(node, nodes.Scenario) else node.body)
        except Return:
            return

    def block(self, statements: Sequence[ast.stmt]) -> Iterator[Step]:
        """Some statements, in order. Those in which time cannot pass are executed as in a function."""
        for node in statements:
            handler = self.episode.suspending.get(type(node)) if lets_time_pass(node) else None
            try:
                if handler is None:
                    self.scope.run([node])
                else:
                    yield from handler(self, node)
            except ScenicError as error:
                raise self.scope.placed(error, node) from None

    # ------------------------------------------------------------ guards

    def check_guards(self) -> None:
        """Preconditions, then invariants."""
        self._check("precondition", self.call.behavior.node.preconditions)
        self.check_invariants()

    def check_invariants(self) -> None:
        """Whenever this thread goes on after time has passed."""
        self._check("invariant", self.call.behavior.node.invariants)

    def _check(self, word: str, conditions: list[ast.expr]) -> None:
        for condition in conditions:
            if not self._holds(condition):
                name = self.call.behavior.name
                raise Guarded(f"violated {word} of {name} on line {condition.lineno}")

    def _holds(self, condition: ast.expr) -> bool:
        """Whether a guard holds; one that has nothing to draw from does not."""
        try:
            return self.scope.truth(condition)
        except ScenicError as error:
            if error.kind == "rejection":
                return False
            raise

    # ------------------------------------------------------------ others inside this one

    def can_start(self, call: BehaviorCall) -> bool:
        """Whether the guards of what may be chosen hold now."""
        try:
            Thread(self.episode, call, self.agent, self.scenario).check_guards()
        except Guarded:
            return False
        return True

    def invoked(self, calls: list[BehaviorCall]) -> Iterator[Step]:
        """Run a sub-behavior of the same agent in place; the checker has seen that it is only one."""
        thread = Thread(self.episode, calls[0], self.agent, self.scenario)
        thread.depth = self.depth + 1
        if thread.depth > DEEPEST:
            raise ScenicError("budget", f"behaviors call each other more than {DEEPEST} deep")
        thread.check_guards()
        yield from thread.run()

    def error(self, kind: str, message: str, node: ast.AST) -> ScenicError:
        return self.scope.error(kind, message, node)


@lru_cache(maxsize=4096)
def lets_time_pass(node: ast.stmt) -> bool:
    """Whether a statement is or contains one that suspends its thread or acts on its blocks."""
    return any(isinstance(each, SUSPENDING) for each in nodes.walk_own(node))


SUSPENDING = (nodes.Take, nodes.Wait, nodes.Do, nodes.Terminate, nodes.Abort, nodes.TryInterrupt)
