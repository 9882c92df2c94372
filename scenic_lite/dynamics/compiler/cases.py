"""`match` as `if`: what a pattern asks of its subject, as an expression.

Read next: `dynamics.compiler.statements`.
"""

from __future__ import annotations

import ast
from functools import lru_cache

from scenic_lite.errors import ScenicError

SUBJECT = "(what is matched)"


@lru_cache(maxsize=1024)  # the compiler knows variables by the nodes that make them
def branches_of(node: ast.Match) -> tuple[ast.stmt, ...]:
    """The cases of a statement, whose subject is the variable SUBJECT."""
    rest: list[ast.stmt] = []
    for case in reversed(node.cases):
        asked, name = question(case.pattern)
        body = list(case.body)
        if name is not None:
            given = ast.copy_location(ast.NamedExpr(ast.Name(name, ast.Store()), subject()), case.pattern)
            true_then = ast.Subscript(ast.Tuple([given, ast.Constant(True)], ast.Load()), ast.Constant(1), ast.Load())
            asked = ast.BoolOp(ast.And(), [asked, true_then])
        if case.guard is not None:
            asked = ast.BoolOp(ast.And(), [asked, case.guard])
        rest = [ast.copy_location(ast.If(placed(asked, case.pattern), body, rest), case.pattern)]
    return tuple(rest)


def question(pattern: ast.pattern) -> tuple[ast.expr, str | None]:
    """The condition of a pattern, and the name that it gives to the whole subject."""
    if isinstance(pattern, ast.MatchValue):
        return ast.Compare(subject(), [ast.Eq()], [pattern.value]), None
    if isinstance(pattern, ast.MatchSingleton):
        return ast.Compare(subject(), [ast.Is()], [ast.Constant(pattern.value)]), None
    if isinstance(pattern, ast.MatchAs):
        asked = ast.Constant(True) if pattern.pattern is None else question(pattern.pattern)[0]
        return asked, pattern.name
    if isinstance(pattern, ast.MatchOr):
        return ast.BoolOp(ast.Or(), [question(each)[0] for each in pattern.patterns]), None
    message = "a pattern that takes its subject apart, of a value that the match decides"
    raise ScenicError("unsupported", message, hint="write if")


def subject() -> ast.expr:
    return ast.Name(SUBJECT, ast.Load())


def placed(tree: ast.expr, where: ast.pattern) -> ast.expr:
    """The expression in the place of a pattern, for its messages."""
    for each in ast.walk(tree):
        if isinstance(each, ast.expr) and not hasattr(each, "lineno"):
            ast.copy_location(each, where)
    return tree
