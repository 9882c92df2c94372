"""Loops in behaviors and monitors that would hold up a simulation step for ever.

Within one step the world stands still, so a loop must either let time pass or change what ends it. Only what is certain
is reported: a loop that takes an action on some path, or that leaves itself, is believed. Read next: `syntax.check`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from scenic_lite.syntax import nodes

SUSPENDING = (nodes.Take, nodes.Wait, nodes.Do)
# A `terminate` ends more than the loop, but is usually one half of "look in each step", so it is no excuse.
LEAVING = (ast.Break, ast.Return)
_SCOPES = (ast.FunctionDef, ast.ClassDef, ast.Lambda)


def suspends(statements: Iterable[ast.AST]) -> bool:
    """Is there a statement among these, at any depth, that lets time pass or ends the scenario?"""
    return any(isinstance(node, (*SUSPENDING, nodes.Terminate)) for node in _within(statements))


def endless_loop(loop: ast.While) -> bool:
    """Does this loop, once it is running, never let time pass and never end?"""
    body = list(_within(loop.body))
    if any(isinstance(node, (*SUSPENDING, *LEAVING)) for node in body):
        return False
    if isinstance(loop.test, ast.Constant):
        return bool(loop.test.value)
    if any(isinstance(node, ast.Call | ast.NamedExpr) for node in [*body, *ast.walk(loop.test)]):
        return False
    read = {node.id for node in ast.walk(loop.test) if isinstance(node, ast.Name)}
    return not read & set(_changed(body))


def _within(statements: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """All nodes of the statements, but for those in functions and classes defined there."""
    pending = list(statements)
    while pending:
        node = pending.pop()
        yield node
        if not isinstance(node, _SCOPES):
            pending.extend(ast.iter_child_nodes(node))


def _changed(body: Iterable[ast.AST]) -> Iterator[str]:
    """The names that are assigned to, or whose attributes or elements are."""
    for node in body:
        if isinstance(node, ast.Name | ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
            target: ast.expr = node
            while isinstance(target, ast.Attribute | ast.Subscript):
                target = target.value
            if isinstance(target, ast.Name):
                yield target.id
