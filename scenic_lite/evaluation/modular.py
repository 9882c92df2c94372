"""Modular scenarios while a program is loaded: which one the program is, and its setup.

Spec section 11.8: `Main`, or the only scenario if it needs no arguments, or the one asked for; a program without any is
a scenario itself. The main one's setup runs when the program is loaded, after the statements outside of scenarios; it
takes over their objects, parameters and requirements, but not their monitors, records and conditions to terminate. What
happens in episodes is in `dynamics.scenarios`. Read next: `loader`.
"""

from __future__ import annotations

from scenic_lite.core.environment import Source, near
from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LoadState, Mode
from scenic_lite.core.types import Behavior, BehaviorCall
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.evaluation.calls import bind


def set_up_main(mode: Mode, source: Source, name: str | None) -> None:
    """Run the setup of the main scenario, if there is one. Raises ScenicError if it cannot be told which one is."""
    state = mode.state
    scenario = main_of(state, source, name)
    if scenario is None:
        return
    place = scenario.scope.place(scenario.node)
    try:
        arguments = bind(scenario.name, scenario.node.args, scenario, [], {})
    except ScenicError as error:
        error.hint = "the scenario that a program is gets no arguments: give its parameters defaults"
        raise scenario.scope.placed(error, scenario.node) from None
    state.main = BehaviorCall(scenario, arguments, place)
    scope = state.main_frame = scenario_frame(mode, state.main)
    state.monitors, state.terminations, state.records = [], [], []
    scope.run(scenario.scenario.setup)


def main_of(state: LoadState, source: Source, name: str | None) -> Behavior | None:
    """The scenario that the program is, among those of its own file."""
    known = {each.name: each for each in state.scenarios if each.scope.source is source}
    if name is not None:
        if name not in known:
            raise ScenicError("name", f"{source.file} has no scenario '{name}'", hint=near(name, known))
        return known[name]
    if "Main" in known:
        return known["Main"]
    if len(known) > 1:
        hint = 'call the one to run "Main", or say which one it is'
        message = f"there are several scenarios: {', '.join(known)}"
        raise ScenicError("value", message, SourceSpan(source.file, 1, 0, 1, 1), hint=hint, source_line=source.line(1))
    only = next(iter(known.values()), None)
    return only if only is not None and not needs_arguments(only) else None


def needs_arguments(scenario: Behavior) -> bool:
    parameters = scenario.node.args
    positional = len(parameters.posonlyargs) + len(parameters.args)
    return positional > len(scenario.defaults) or len(parameters.kwonlyargs) > len(scenario.keyword_defaults)


def scenario_frame(mode: Mode, call: BehaviorCall) -> Scope:
    """A frame for the names of one run of a scenario, shared by its setup and its compose block."""
    call.names.clear()
    call.names.update(call.arguments)
    scope = Scope.inside(mode, call.behavior.scope, call.names)
    scope.assigned = call.behavior.assigned
    return scope
