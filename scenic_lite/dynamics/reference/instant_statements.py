"""What statements that take no time mean while an episode runs: `require`, `require monitor`, `override`, `new`.

In the setup of a scenario the other statements mean what they mean while a program is loaded: what they make is kept by
that scenario (`scenarios`). Read next: `dynamics.reference.interpreter`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scenic_lite.core.bindings import Bindings
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import Watched
from scenic_lite.core.types import BehaviorCall, describe_kind
from scenic_lite.dynamics.reference.episode import Episode, Rejected
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import checked, is_object
from scenic_lite.language.requirements import source_text
from scenic_lite.language.specifiers import overridden_property
from scenic_lite.language.temporal import is_temporal
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value, is_number


def statements_of(episode: Episode) -> dict[type, Callable[[Scope, Any], None]]:
    """The handlers for one episode."""
    return {
        nodes.Require: lambda scope, node: require(episode, scope, node),
        nodes.RequireMonitor: lambda scope, node: require_monitor(episode, scope, node),
        nodes.Override: lambda scope, node: override(episode, scope, node),
    }


def require(episode: Episode, scope: Scope, node: nodes.Require) -> None:
    """`require[p] c` holds now, or the episode is rejected; a temporal one is watched by the scenario from now on."""
    label = node.name or source_text(scope, node)
    if is_temporal(node.condition):
        watched = Watched(node, scope.place(node), scope, label, Bindings(scope))
        if episode.scenario.running:
            episode.scenario.add_temporal(watched)
        else:
            scope.state.temporal.append(watched)
        return
    probability = 1.0 if node.probability is None else scope.value(node.probability)
    if not is_number(probability) or not 0 <= probability <= 1:
        raise scope.error("value", "the probability of a requirement must be a number from 0 to 1", node)
    if probability < 1 and episode.draws.uniform() > probability:
        return
    if not scope.truth(node.condition):
        raise Rejected(label)


def require_monitor(episode: Episode, scope: Scope, node: nodes.RequireMonitor) -> None:
    """Start a monitor with the scenario, or at once if that is running."""
    value = scope.value(node.call)
    if not isinstance(value, BehaviorCall) or value.behavior.kind != "monitor":
        raise scope.error("type", f"`require monitor` needs a monitor, not {describe_kind(value)}", node.call)
    if episode.scenario.running:
        episode.scenario.add_monitor(value)
    else:
        scope.state.monitors.append(value)


def override(episode: Episode, scope: Scope, node: nodes.Override) -> None:
    """`override object with p v, ...`, until the scenario ends."""
    target = scope.value(node.target)
    if not is_object(target):
        raise scope.error("type", f"`override` needs an object, not {describe_kind(target)}", node.target)
    values: dict[str, Value] = {}
    for each in node.specifiers:
        name, value = overridden_property(scope, each)
        if name in episode.live_names(target):
            raise scope.error("specifier", f"'{name}' is of the simulator and cannot be overridden", each)
        if name not in target.properties:
            raise scope.error("specifier", f"{target.title()} has no property '{name}' to override", each)
        values[name] = checked(name, value, scope.state.dialect)
    episode.scenario.override(target, values)


def making_objects(episode: Episode, new: Callable[[Scope, nodes.New], Value]) -> Callable[[Scope, nodes.New], Value]:
    """`new`, but only in the setup of a scenario."""

    def make(scope: Scope, node: nodes.New) -> Value:
        before = len(episode.objects)
        made = new(scope, node)
        if episode.scenario.running and len(episode.objects) > before:
            del episode.objects[before:]
            hint = "make it before, or in the setup of a scenario"
            raise ScenicError("type", "no object can be made in a behavior", hint=hint)
        return made

    return make
