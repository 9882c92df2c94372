"""What an episode may read: the values that behaviors, monitors and conditions mention; what is random in them is in θ.

Random values that a behavior names are sampled with the scene, those that it draws itself are not. Read
next: `scenic_lite.core.per_sample`, which follows names.
"""

from __future__ import annotations

import ast

from scenic_lite.core.environment import Environment
from scenic_lite.core.per_sample import body_of, reached
from scenic_lite.core.state import LoadState
from scenic_lite.core.types import BehaviorCall, Instance
from scenic_lite.values.graph import Value


def read_in_episodes(state: LoadState, objects: list[Instance]) -> list[Value]:
    """Every value that the dynamic half of a program names, directly or through functions and other behaviors."""
    attached = [instance.properties["behavior"] for instance in objects]
    calls = [each for each in (*attached, *state.monitors) if isinstance(each, BehaviorCall)]
    watched = (*state.terminations, *state.records, *state.temporal)
    pending: list[tuple[Environment, ast.AST]] = [(each.scope, each.tree) for each in watched]
    for call in calls:
        pending += [(call.behavior.scope, part) for part in body_of(call.behavior)]
    if state.main is not None and state.main_frame is not None:
        pending.append((state.main_frame, state.main.behavior.node))
    return [*(call.arguments for call in calls), *reached(pending)]
