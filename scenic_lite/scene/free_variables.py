"""What an episode may read: the values that behaviors, monitors and conditions mention; what is random in them is in θ.

Random values that a behavior names are sampled with the scene, those that it draws itself are not. Read
next: `scenic_lite.core.per_sample`, which follows names.
"""

from __future__ import annotations

import ast

from scenic_lite.core.per_sample import body_of, reached
from scenic_lite.core.scope import InterpreterState, Scope
from scenic_lite.core.types import BehaviorCall, Instance
from scenic_lite.values.graph import Value


def read_in_episodes(session: InterpreterState, objects: list[Instance]) -> list[Value]:
    """Every value that the dynamic half of a program names, directly or through functions and other behaviors."""
    attached = [instance.properties["behavior"] for instance in objects]
    calls = [each for each in (*attached, *session.monitors) if isinstance(each, BehaviorCall)]
    watched = (*session.terminations, *session.records, *session.temporal)
    pending: list[tuple[Scope, ast.AST]] = [(each.scope, each.tree) for each in watched]
    for call in calls:
        pending += [(call.behavior.scope, part) for part in body_of(call.behavior)]
    if session.main is not None and session.main_frame is not None:
        pending.append((session.main_frame, session.main.behavior.node))
    return [*(call.arguments for call in calls), *reached(pending)]
