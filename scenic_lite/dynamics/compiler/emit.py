"""From nodes to rows: each operation of the evaluator's graph becomes an opcode.

A node that does not depend on the running match is an input, which is computed once, with the scene. A node that can
fail, such as 1 / x for a column x, is an exception: it must fail at its point in the match. Read next:
`dynamics.compiler.types`, the types of variables.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import FunctionType
from typing import Any

import numpy as np

from scenic_lite.dynamics.compiler.code import Assembler, Label, Operands, RuntimeDraw
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.bytecode import DOMAIN_ERROR, FAULT_MESSAGES
from scenic_lite.dynamics.machine.opcodes import NUMBERS, OPCODES
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.language import distributions
from scenic_lite.values import operations
from scenic_lite.values.graph import RandomExpr, Table, ThetaColumn, Value, apply
from scenic_lite.values.operations import Operation, row_of
from scenic_lite.values.polygons import Holds

# Operations with the result -0.0 for registers, but 0 for Python's integers.
MINUS_ZEROS = (operations.MULTIPLY, operations.MODULO, operations.NEGATE)


def opcode_of(row: Operation) -> int:
    return NUMBERS[row.opcode]


COMPUTED = "write it with what can: arithmetic, sqrt, exp, log, sin, cos, atan2, hypot, floor, ceil, round"


def register_of(code: Assembler, value: Value, into: int | None = None) -> int:
    """Write the rows that compute a number, truth value or text; return its register.

    With `into`, that register receives the value.
    """
    if isinstance(value, RandomExpr):
        register = _register(code, value, into)
    elif isinstance(value, bool | int | float | str | np.number | np.bool_):
        register = code.constant(value)  # type: ignore[arg-type]
    else:
        raise TypeError(f"no register holds {value!r}")
    if into is not None and register != into:
        code.row(op.COPY, into, register)
        return into
    return register


def _register(code: Assembler, node: RandomExpr, into: int | None) -> int:
    if isinstance(node, RegisterValue | RuntimeDraw):
        return node.register
    if id(node) in code.known:
        return code.known[id(node)][0]
    if not is_live(node):
        return code.input(node)
    out = code.temporaries.take() if into is None else into
    compute(code, node, out)
    if into is None:
        code.known[id(node)] = (out, node)
    return out


def is_live(value: Value) -> bool:
    """Return whether a value is computed in the running match, not at its start."""
    if isinstance(value, RegisterValue | RuntimeDraw):
        return True
    if not isinstance(value, RandomExpr):
        return False
    pending, seen = list(value.inputs), set()
    while pending:
        node = pending.pop()
        if isinstance(node, RandomExpr) and node not in seen:
            if isinstance(node, RegisterValue | RuntimeDraw):
                return True
            seen.add(node)
            pending.extend(node.inputs)
    return can_fail(value)


def can_fail(node: RandomExpr) -> bool:
    """Return whether the computation of a node has an operation that fails for some numbers."""
    pending: list[Value] = [node]
    seen = set()
    while pending:
        value = pending.pop()
        if not isinstance(value, RandomExpr) or id(value) in seen:
            continue
        seen.add(id(value))
        row = table_row(value.operation)
        if row is None or (row.opcode and is_test(row)):
            continue
        if row.fails is not None and not _harmless(row, value.inputs[-1]):
            return True
        if row not in (operations.AND, operations.OR):
            pending.extend(value.inputs)
    return False


def _harmless(row: Operation, operand: Value) -> bool:
    """Return whether division by the operand, or a power with this exponent, never fails."""
    if isinstance(operand, RandomExpr):
        return False
    return operand >= 0 and operand == int(operand) if row.opcode == "POWER" else operand != 0


def table_row(operation: Any) -> Operation | None:
    """Return the table row of an operation, or None."""
    return row_of(operation) if type(operation).__hash__ is not None else None


def is_test(row: Operation) -> bool:
    """Return whether the opcode of an operation takes a list of operands."""
    return OPCODES[opcode_of(row)].operands.endswith("l")


def compute(code: Assembler, node: RandomExpr, out: int) -> None:
    """Write the rows for one operation, operands first."""
    row = table_row(node.operation)
    if row is None or not row.opcode:
        special = next((write for kind, write in SPECIAL if _is(node.operation, kind)), None)
        if row is not None and row.fails is not None and not any(map(is_live, node.inputs)):
            special = of_scene
        if special is None:
            message = f"`{describe(node.operation)}` cannot be computed while a match runs"
            raise ScenicError("unsupported", message, hint=COMPUTED)
        special(code, node, out)
        return
    registers = tuple(register_of(code, operand) for operand in node.inputs)
    if is_test(row):
        code.row(opcode_of(row), out, 0, Operands(registers))
        return
    first, second = registers if len(registers) == 2 else (registers[0], 0)
    if row.swapped:
        first, second = second, first
    code.row(opcode_of(row), out, first, second)
    if row in MINUS_ZEROS and is_whole(node):
        code.row(op.ADD, out, out, code.constant(0))


def of_scene(code: Assembler, node: RandomExpr, out: int) -> None:
    """Write rows that read a value computed with the scene; a match in which it is not finite faults."""
    register_of(code, RegisterValue(code.input(node)), out)
    fault_unless_finite(code, out, FAULT_MESSAGES[DOMAIN_ERROR])


def fault_unless_finite(code: Assembler, register: int, message: str) -> None:
    """Write rows that stop a match in which a number is infinite or NaN."""
    finite = code.temporaries.take()
    code.row(op.SUBTRACT, finite, register, register)
    code.row(op.EQUAL, finite, finite, code.constant(0))
    code.fault_unless(finite, message)


def _is(operation: Any, kind: Any) -> bool:
    return isinstance(operation, kind) if isinstance(kind, type) else operation is kind


def describe(operation: Any) -> str:
    """Return the name of an operation for messages."""
    name = operation.__name__ if isinstance(operation, np.ufunc | FunctionType) else type(operation).__name__
    return name.strip("_").replace("_", " ")


def select(code: Assembler, node: RandomExpr, out: int) -> None:
    """Write rows that select one of several values, by a live index."""
    index, *options = node.inputs
    if isinstance(node.operation, Table):
        options = node.operation.options.tolist()
    registers = tuple(register_of(code, option) for option in options)
    code.row(op.SELECT, out, register_of(code, index), Operands(registers))


def bucketize(code: Assembler, node: RandomExpr, out: int) -> None:
    assert isinstance(node.operation, distributions.Bucketize)
    bounds = tuple(code.constant(float(bound)) for bound in node.operation.bounds)
    code.row(op.BUCKETIZE, out, register_of(code, node.inputs[0]), Operands(bounds))


def in_shape(code: Assembler, node: RandomExpr, out: int) -> None:
    """Write rows that test whether a point is in a fixed polygon; the edges are operands."""
    import shapely

    assert isinstance(node.operation, Holds)
    x, y = node.inputs
    edges: list[float] = []
    for ring in shapely.get_rings(shapely.get_parts(node.operation.shape)):
        corners = shapely.get_coordinates(ring)
        edges += np.hstack([corners[:-1], corners[1:]]).ravel().tolist()
    if len(edges) > 4000:
        raise ScenicError("unsupported", "a region of more than 1000 edges cannot be tested for points in a match")
    registers = (register_of(code, x), register_of(code, y), *(code.constant(edge) for edge in edges))
    code.row(op.IN_RINGS, out, 0, Operands(registers))


def by(expression: Callable[..., Value]) -> Callable[[Assembler, RandomExpr, int], object]:
    """Return a function that writes the rows of an operation that is an expression of other operations."""
    return lambda code, node, out: register_of(code, expression(*node.inputs), out)


SPECIAL: tuple[tuple[Any, Callable[[Assembler, RandomExpr, int], object]], ...] = (
    (Table, select),
    (operations.SELECT.array, select),
    (distributions.Bucketize, bucketize),
    (Holds, in_shape),
    (
        operations.CLIP.array,
        by(lambda x, low, high: apply(operations.MINIMUM, apply(operations.MAXIMUM, x, low), high)),
    ),
    (operations.WHERE.array, by(lambda test, yes, no: RandomExpr(operations.SELECT.array, (test, no, yes)))),
    (operations.TRUTH.array, by(lambda x: apply(operations.NOT_EQUAL, x, 0))),
    (operations.RADIANS.array, by(lambda x: apply(operations.MULTIPLY, x, math.pi / 180))),
    (operations.DEGREES.array, by(lambda x: apply(operations.MULTIPLY, x, 180 / math.pi))),
)


def is_whole(value: Value) -> bool:
    """Return whether a number is an integer in Python, whose text has no decimal point."""
    if isinstance(value, RegisterValue):
        return value.whole
    if not isinstance(value, RandomExpr):
        return isinstance(value, int | np.integer) and not isinstance(value, bool)
    if isinstance(value, ThetaColumn):
        return False
    operation = value.operation
    if isinstance(operation, Table):
        return operation.options.dtype.kind == "i"
    if operation is operations.SELECT.array:
        return all(map(is_whole, value.inputs[1:]))
    if isinstance(operation, distributions.Bucketize):
        return True
    row = table_row(operation)
    if row is None or row.integers != operations.KEPT:
        return row is not None and row.integers == operations.ALWAYS
    return all(map(is_whole, value.inputs))


# ------------------------------------------------------------ jumps

JUMPS: dict[int, tuple[int, int]] = {  # opcode of a test -> opcodes of the jumps if it holds, and if it fails
    op.LESS: (op.JUMP_LESS, op.JUMP_NOT_LESS),
    op.LESS_EQUAL: (op.JUMP_LESS_EQUAL, op.JUMP_NOT_LESS_EQUAL),
    op.EQUAL: (op.JUMP_EQUAL, op.JUMP_NOT_EQUAL),
    op.NOT_EQUAL: (op.JUMP_NOT_EQUAL, op.JUMP_EQUAL),
}


def jump(code: Assembler, test: Value, target: Label, when: bool) -> None:
    """Jump to the target if the truth of `test` is `when`."""
    if not isinstance(test, RandomExpr):
        if bool(test) == when:
            code.row(op.JUMP, c=target)
        return
    row = table_row(test.operation)
    if row is operations.NOT:
        jump(code, test.inputs[0], target, not when)
    elif row is not None and row.opcode and opcode_of(row) in JUMPS and is_live(test) and id(test) not in code.known:
        holds, fails = JUMPS[opcode_of(row)]
        left, right = (register_of(code, operand) for operand in test.inputs)
        left, right = (right, left) if row.swapped else (left, right)
        code.row(holds if when else fails, left, right, target)
    else:
        code.row(op.JUMP_IF if when else op.JUMP_UNLESS, register_of(code, test), c=target)
