"""`with behavior Uniform(A(), B())`: a behavior that does the one of several which the scene has drawn.

Spec section 7: behaviors may be drawn like anything else. Read next: `language.specifiers`.
"""

from __future__ import annotations

import ast

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Behavior, BehaviorCall, RandomChoice
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value


def one_behavior(scope: Scope, node: ast.expr, value: Value) -> Value:
    """A drawn behavior as the behavior `A or B(chosen): do chosen`; any other value as it is."""
    if not isinstance(value, RandomChoice) or not all(isinstance(each, BehaviorCall) for each in value.options):
        return value
    name = " or ".join(dict.fromkeys(each.behavior.name for each in value.options))
    do = nodes.Do([ast.Name("chosen", ast.Load())], "all", None, None, None, None)
    parameters = ast.arguments([], [ast.arg("chosen")], None, [], [], None, [])
    tree = nodes.Behavior(name, parameters, [], [], [do], "behavior", None)
    for each in (do, do.calls[0], tree):
        ast.copy_location(each, node)
    return BehaviorCall(Behavior(name, tree, (), {}, scope), {"chosen": value}, scope.place(node))
