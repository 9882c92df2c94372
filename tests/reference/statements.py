"""What statements mean while an episode runs: those in which time may pass, as generators, and those of an instant.

Order of one `take`: its actions are evaluated from left to right, then checked by the world; when the thread is
resumed its invariants are checked before the next statement. The same after `wait`, `terminate` (a behavior whose own
scenario has ended may go on) and the end of a `do`. In the setup of a scenario the other statements mean what they mean
while a program is loaded: what they make is kept by that scenario (`dynamics.reference.scenarios`).
A `print` in a running match is silent: a thousand matches have no one to print to; `record` shows a value.
Read next: `dynamics.reference.interrupts`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any

from scenic_lite.core.per_sample import Bindings
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import EpisodeStatement
from scenic_lite.core.types import Instance
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation import statements as loading
from scenic_lite.evaluation.calls import refuse_as_action
from scenic_lite.language.classes import is_object
from scenic_lite.language.requirements import is_temporal, probability_of, source_text
from scenic_lite.language.specifiers import overridden_properties
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value
from tests.reference.episode import Episode, Rejected, sampled
from tests.reference.interrupts import abort, do, try_interrupt, wait
from tests.reference.threads import End, Step, Thread


# ------------------------------------------------------------ in which time may pass
def branch(thread: Thread, node: ast.If) -> Iterator[Step]:
    return thread.block(node.body if thread.scope.truth(node.test) else node.orelse)


def repeat(thread: Thread, node: ast.For | ast.While) -> Iterator[Step]:
    return loading.loop(thread.scope, node, thread.block)


def take(thread: Thread, node: nodes.Take) -> Iterator[Step]:
    """Run `take a, b`; a single tuple or list stands for its elements."""
    row = thread.episode.row
    actions = [sampled(thread.scope.value(action), row) for action in node.actions]
    if len(actions) == 1 and isinstance(actions[0], list | tuple):
        actions = list(actions[0])
    assert thread.agent is not None, "the checker lets only behaviors take actions"
    for action in actions:
        refuse_as_action(action)
    yield tuple(thread.episode.world.command(action, thread.agent) for action in actions)


def terminate(thread: Thread, node: nodes.Terminate) -> Iterator[Step]:
    """Run `terminate`, which in Scenic 2 always means the simulation."""
    extent = "simulation" if thread.episode.program.dialect == 2 else node.scope
    yield End(extent, "terminate" if node.scope == "scenario" else "terminate simulation", node.lineno)


SUSPENDING: dict[type, Callable[[Thread, Any], Iterator[Step]]] = {
    ast.If: branch,
    ast.For: repeat,
    ast.While: repeat,
    nodes.TryInterrupt: try_interrupt,
    nodes.Take: take,
    nodes.Wait: wait,
    nodes.Do: do,
    nodes.Terminate: terminate,
    nodes.Abort: abort,
}


# ------------------------------------------------------------ of an instant
def instant_statements(episode: Episode) -> dict[type, Callable[[Scope, Any], None]]:
    """Return the handlers for one episode."""
    return {
        nodes.Require: lambda scope, node: require(episode, scope, node),
        nodes.RequireMonitor: lambda scope, node: require_monitor(episode, scope, node),
        nodes.Override: lambda scope, node: override(episode, scope, node),
    }


def require(episode: Episode, scope: Scope, node: nodes.Require) -> None:
    """Reject the episode unless `require[p] c` holds now; a temporal one is watched by the scenario from now on."""
    label = node.name or source_text(scope, node)
    if is_temporal(node.condition):
        watched = EpisodeStatement(node, scope.place(node), scope, label, Bindings(scope))
        if episode.scenario.running:
            episode.scenario.add_temporal(watched)
        else:
            scope.state.temporal.append(watched)
        return
    probability = probability_of(scope, node)
    if probability < 1 and episode.uniform() > probability:
        return
    if not scope.truth(node.condition):
        raise Rejected(label)


def require_monitor(episode: Episode, scope: Scope, node: nodes.RequireMonitor) -> None:
    """Start a monitor with the scenario, or at once if that is running."""
    loading.require_monitor(scope, node)
    if episode.scenario.running:
        episode.scenario.add_monitor(scope.state.monitors.pop())


def override(episode: Episode, scope: Scope, node: nodes.Override) -> None:
    """Execute `override object with p v, ...`, until the scenario ends."""
    target = scope.value(node.target)
    live = episode.world.properties(target, dict.fromkeys(episode.world.fields, 0.0)) if is_object(target) else ()
    episode.scenario.override(target, overridden_properties(scope, node, target, live))


def making_objects(episode: Episode, new: Callable[[Scope, nodes.New], Value]) -> Callable[[Scope, nodes.New], Value]:
    """Return the handler of `new`, which may make objects only in the setup of a scenario."""

    def make(scope: Scope, node: nodes.New) -> Value:
        before = len(episode.objects)
        made = new(scope, node)
        if episode.scenario.running and len(episode.objects) > before:
            del episode.objects[before:]
            hint = "make it before, or in the setup of a scenario"
            raise ScenicError("type", "no object can be made in a behavior", hint=hint)
        if isinstance(made, Instance) and not is_object(made):  # a point stays where it was drawn
            made.properties = {name: sampled(value, episode.row) for name, value in made.properties.items()}
        return made

    return make
