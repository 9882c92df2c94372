"""`try`, `raise` and `assert`.

A program catches what it could catch in Python, by the names of `exceptions`; never the end of its budget. Read next:
`core.exceptions`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from scenic_lite.core.exceptions import EXCEPTIONS, ExceptionClass, Fault, fault_of, named_fault, raised
from scenic_lite.core.scope import Scope
from scenic_lite.core.types import describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.strings import text_of
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value


def attempt(scope: Scope, node: ast.Try) -> None:
    """`try` with any of `except`, `else`, `finally`."""
    try:
        guarded(scope, node)
    finally:
        scope.run(node.finalbody)


def guarded(scope: Scope, node: ast.Try) -> None:
    """All of it but the `finally`."""
    try:
        scope.run(node.body)
    except ScenicError as error:
        fault = None if decides_by_row(scope, error) else fault_of(error)
        handler = None if fault is None else handler_for(scope, node, fault)
        if fault is None or handler is None:
            raise
        handle(scope, handler, fault, error)
    else:
        scope.run(node.orelse)


def decides_by_row(scope: Scope, error: ScenicError) -> bool:
    """Whether a requirement will be evaluated again, scene by scene, because of this error."""
    return error.kind == "random-control-flow" and scope.mode.symbolic and scope.mode.row is None


def handler_for(scope: Scope, node: ast.Try | nodes.TryInterrupt, fault: Fault) -> ast.ExceptHandler | None:
    """The first `except` that holds the exception."""
    for handler in node.handlers:
        if handler.type is None:
            return handler
        value = scope.value(handler.type)
        for cls in value if isinstance(value, tuple) else (value,):
            if not isinstance(cls, ExceptionClass):
                raise scope.error("type", f"`except` needs an exception, not {describe_kind(cls)}", handler.type)
            if fault.cls.derives_from(cls):
                return handler
    return None


def handle(scope: Scope, handler: ast.ExceptHandler, fault: Fault, error: ScenicError) -> None:
    """Run the block of an `except`; its name ends with it."""
    handled = scope.state.handled
    handled.append(error)
    if handler.name is not None:
        scope.assign(handler.name, fault)
    try:
        scope.run(handler.body)
    finally:
        handled.pop()
        if handler.name is not None:
            scope.names_of(handler.name).pop(handler.name, None)


def throw(scope: Scope, node: ast.Raise) -> None:
    """`raise`, `raise E`, `raise E(...)`, with or without `from`."""
    if node.exc is None:
        if not scope.state.handled:
            raise named_fault("RuntimeError", scope.error("value", "there is no exception to raise again", node))
        raise scope.state.handled[-1]
    value = scope.value(node.exc)
    if node.cause is not None:
        scope.value(node.cause)
    if isinstance(value, ExceptionClass):
        value = Fault(value)
    if not isinstance(value, Fault):
        raise scope.error("type", f"`raise` needs an exception, not {describe_kind(value)}", node.exc)
    raise raised(value)


def certify(scope: Scope, node: ast.Assert) -> None:
    if scope.truth(node.test):
        return
    message: Value = None if node.msg is None else scope.value(node.msg)
    text = "" if message is None else f": {text_of(scope, message)}"
    error = named_fault("AssertionError", ScenicError("value", f"the assertion does not hold{text}"))
    error.fault = Fault(EXCEPTIONS["AssertionError"], () if message is None else (message,))
    raise error


def starred(scope: Scope, node: ast.TryStar) -> None:
    raise ScenicError("unsupported", "`except*` is not supported", hint="write except")


TRYING: dict[type, Callable[[Scope, Any], None]] = {
    ast.Try: attempt,
    ast.TryStar: starred,
    ast.Raise: throw,
    ast.Assert: certify,
}
