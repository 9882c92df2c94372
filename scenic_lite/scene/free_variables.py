"""What an episode may read: the values that behaviors, monitors and conditions mention; what is random in them is in θ.

Spec section 3: random values that a behavior names are sampled with the scene, those that it draws itself are not. Read
next: `scenic_lite.core.per_sample`, which follows names.
"""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from scenic_lite.core.per_sample import body_of, reached
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import BehaviorCall
from scenic_lite.values.graph import Value

if TYPE_CHECKING:
    from scenic_lite.scene.program import Program


def read_in_episodes(program: Program) -> list[Value]:
    """Every value that the dynamic half of a program names, directly or through functions and other behaviors."""
    attached = [instance.properties["behavior"] for instance in program.instances]
    calls = [each for each in (*attached, *program.monitors) if isinstance(each, BehaviorCall)]
    watched = (*program.terminations, *program.records, *program.temporal)
    pending: list[tuple[Scope, ast.AST]] = [(each.scope, each.tree) for each in watched]
    for call in calls:
        pending += [(call.behavior.scope, part) for part in body_of(call.behavior)]
    if program.main is not None and program.main_frame is not None:
        pending.append((program.main_frame, program.main.behavior.node))
    return [*(call.arguments for call in calls), *reached(pending)]
