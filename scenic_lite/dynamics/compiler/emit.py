"""From nodes to rows: each operation of the evaluator's graph becomes an opcode.

A node that mentions nothing of the running match is an input: it is computed once, with the scene. Not so if that can
fail, as 1 / x of a column x: it must fail when and where the match comes to it. Read next: `dynamics.compiler.types`,
which says what a variable holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import FunctionType
from typing import Any

import numpy as np

from scenic_lite.dynamics.compiler.code import Assembler, DrawnNow, Label, Operands
from scenic_lite.dynamics.machine import opcodes as op
from scenic_lite.dynamics.machine.register_values import RegisterValue
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation import math_builtins
from scenic_lite.evaluation.builtins import TRUE_OR_FALSE
from scenic_lite.language import distributions
from scenic_lite.language.classes import sector_and_rectangle
from scenic_lite.values import geometry, graph, regions
from scenic_lite.values.graph import RandomExpr, Table, ThetaColumn, Value
from scenic_lite.values.polygons import Holds

SIMPLE: dict[Any, int] = {  # operands in their order
    graph.ADD.array: op.ADD,
    graph.SUBTRACT.array: op.SUBTRACT,
    graph.MULTIPLY.array: op.MULTIPLY,
    graph.DIVIDE.array: op.DIVIDE,
    graph.FLOOR_DIVIDE.array: op.FLOOR_DIVIDE,
    graph.MODULO.array: op.MODULO,
    graph.POWER.array: op.POWER,
    graph.NEGATE.array: op.NEGATE,
    graph.ABSOLUTE.array: op.ABSOLUTE,
    graph.LESS.array: op.LESS,
    graph.LESS_EQUAL.array: op.LESS_EQUAL,
    graph.EQUAL.array: op.EQUAL,
    graph.NOT_EQUAL.array: op.NOT_EQUAL,
    graph.AND.array: op.AND,
    graph.OR.array: op.OR,
    graph.NOT.array: op.NOT,
    graph.MINIMUM.array: op.MINIMUM,
    graph.MAXIMUM.array: op.MAXIMUM,
    graph.HYPOTENUSE.array: op.HYPOTENUSE,
    graph.INTEGER.array: op.TRUNCATE,
    graph.ROUND.array: op.ROUND,
    graph.FLOAT.array: op.COPY,
    geometry.NORMALISE.array: op.NORMALISE,
    distributions.normal_quantile: op.QUANTILE,
}
BY_NAME: dict[str, int] = {
    "sin": op.SINE,
    "cos": op.COSINE,
    "tan": op.TANGENT,
    "asin": op.ARC_SINE,
    "acos": op.ARC_COSINE,
    "atan": op.ARC_TANGENT,
    "sqrt": op.SQUARE_ROOT,
    "exp": op.EXPONENTIAL,
    "log": op.LOGARITHM,
    "log2": op.LOGARITHM_2,
    "log10": op.LOGARITHM_10,
    "floor": op.FLOOR,
    "ceil": op.CEILING,
    "fabs": op.ABSOLUTE,
    "atan2": op.ARC_TANGENT_2,
    "copysign": op.COPY_SIGN,
    "fmod": op.REMAINDER,
    "pow": op.POWER,
}
TABLES = (*math_builtins.OF_ONE, *math_builtins.OF_TWO, graph.Operation(math.log, np.log))
SIMPLE |= {array: BY_NAME[scalar.__name__] for scalar, array in TABLES if scalar.__name__ in BY_NAME}
SWAPPED: dict[Any, int] = {graph.GREATER.array: op.LESS, graph.GREATER_EQUAL.array: op.LESS_EQUAL}
LISTED: dict[Any, int] = {
    geometry.in_sector: op.IN_SECTOR,
    regions.in_rectangle: op.IN_RECTANGLE,
    geometry.rectangles_meet: op.RECTANGLES_MEET,
    sector_and_rectangle: op.SECTOR_MEETS,
}
WHOLE = (op.ADD, op.SUBTRACT, op.MULTIPLY, op.FLOOR_DIVIDE, op.MODULO, op.NEGATE, op.ABSOLUTE, op.MINIMUM, op.MAXIMUM)
SIGNED_ZEROS = (op.MULTIPLY, op.MODULO, op.NEGATE)
QUOTIENTS = (op.DIVIDE, op.FLOOR_DIVIDE, op.MODULO, op.REMAINDER)
LOGARITHMS = (op.LOGARITHM, op.LOGARITHM_2, op.LOGARITHM_10)
RISKS = (*QUOTIENTS, *LOGARITHMS, op.POWER, op.SQUARE_ROOT, op.ARC_SINE, op.ARC_COSINE)
ALWAYS_WHOLE = (op.TRUNCATE, op.ROUND, op.FLOOR, op.CEILING)


class Unsupported(ScenicError):
    """What cannot be computed inside the kernel."""

    def __init__(self, what: str, hint: str = "") -> None:
        super().__init__("unsupported", f"{what} while a match runs", hint=hint)


def register_of(code: Assembler, value: Value, into: int | None = None) -> int:
    """The register that holds a number, truth value or text; the rows that compute it are written first.

    With `into` the value is put there.
    """
    if isinstance(value, RandomExpr):
        found = _register(code, value, into)
    elif isinstance(value, bool | int | float | str | np.number | np.bool_):
        found = code.constant(value)  # type: ignore[arg-type]
    else:
        raise TypeError(f"no register holds {value!r}")
    if into is not None and found != into:
        code.row(op.COPY, into, found)
        return into
    return found


def _register(code: Assembler, node: RandomExpr, into: int | None) -> int:
    if isinstance(node, RegisterValue | DrawnNow):
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
    """Whether a value is computed in the running match; what is not is known when it starts."""
    if isinstance(value, RegisterValue | DrawnNow):
        return True
    if not isinstance(value, RandomExpr):
        return False
    pending, seen = list(value.inputs), set()
    while pending:
        node = pending.pop()
        if isinstance(node, RandomExpr) and node not in seen:
            if isinstance(node, RegisterValue | DrawnNow):
                return True
            seen.add(node)
            pending.extend(node.inputs)
    return can_fail(value)


def can_fail(node: RandomExpr) -> bool:
    """Whether arithmetic of which all operands are computed has a step that some numbers cannot take."""
    pending: list[Value] = [node]
    seen = set()
    while pending:
        each = pending.pop()
        if not isinstance(each, RandomExpr) or id(each) in seen or not _hashable(each.operation):
            continue
        seen.add(id(each))
        opcode = SIMPLE.get(each.operation)
        if opcode in RISKS and not _harmless(opcode, each.inputs[-1]):
            return True
        if opcode is not None and opcode not in (op.AND, op.OR):
            pending.extend(each.inputs)
    return False


def _harmless(opcode: int, operand: Value) -> bool:
    """Whether a division by this, or a power of this exponent, is always a number."""
    if isinstance(operand, RandomExpr):
        return False
    return operand >= 0 and operand == int(operand) if opcode is op.POWER else operand != 0


def compute(code: Assembler, node: RandomExpr, out: int) -> None:
    """Rows for one operation, operands first."""
    operation = node.operation
    if _hashable(operation) and operation in SIMPLE:
        opcode = SIMPLE[operation]
        first, *others = [register_of(code, each) for each in node.inputs]
        code.row(opcode, out, first, others[0] if others else 0)
        if opcode in SIGNED_ZEROS and is_whole(node):  # Python's integers have no -0
            code.row(op.ADD, out, out, code.constant(0))
    elif _hashable(operation) and operation in SWAPPED:
        left, right = (register_of(code, each) for each in node.inputs)
        code.row(SWAPPED[operation], out, right, left)
    elif _hashable(operation) and operation in LISTED:
        code.row(LISTED[operation], out, 0, Operands(tuple(register_of(code, each) for each in node.inputs)))
    else:
        special = next((write for kind, write in SPECIAL if _is(operation, kind)), None)
        if special is None:
            raise Unsupported(f"`{describe(operation)}` cannot be computed")
        special(code, node, out)


def _hashable(operation: Any) -> bool:
    return type(operation).__hash__ is not None


def _is(operation: Any, kind: Any) -> bool:
    return isinstance(operation, kind) if isinstance(kind, type) else operation is kind


def describe(operation: Any) -> str:
    """What an operation is called, for a message."""
    name = operation.__name__ if isinstance(operation, np.ufunc | FunctionType) else type(operation).__name__
    return name.strip("_").replace("_", " ")


def choose_constant(code: Assembler, node: RandomExpr, out: int) -> None:
    """One of some constants, by a live index."""
    assert isinstance(node.operation, Table)
    options = [each.item() if isinstance(each, np.generic) else each for each in node.operation.options]
    pick(code, out, node.inputs[0], options)


def choose_value(code: Assembler, node: RandomExpr, out: int) -> None:
    pick(code, out, node.inputs[0], list(node.inputs[1:]))


def pick(code: Assembler, out: int, index: Value, options: list[Value]) -> None:
    registers = tuple(register_of(code, each) for each in options)
    code.row(op.SELECT, out, register_of(code, index), Operands(registers))


def cut(code: Assembler, node: RandomExpr, out: int) -> None:
    assert isinstance(node.operation, distributions.Cut)
    bounds = tuple(code.constant(float(each)) for each in node.operation.bounds)
    code.row(op.BUCKETIZE, out, register_of(code, node.inputs[0]), Operands(bounds))


def integers(code: Assembler, node: RandomExpr, out: int) -> None:
    """first + min(int(u · count), count - 1)."""
    assert isinstance(node.operation, distributions.Integers)
    first, count = node.operation.first, node.operation.count
    code.row(op.MULTIPLY, out, register_of(code, node.inputs[0]), code.constant(count))
    code.row(op.TRUNCATE, out, out)
    code.row(op.MINIMUM, out, out, code.constant(count - 1))
    code.row(op.ADD, out, out, code.constant(first))


def clip(code: Assembler, node: RandomExpr, out: int) -> None:
    value, low, high = (register_of(code, each) for each in node.inputs)
    code.row(op.MAXIMUM, out, value, low)
    code.row(op.MINIMUM, out, out, high)


def as_truth(code: Assembler, node: RandomExpr, out: int) -> None:
    code.row(op.NOT_EQUAL, out, register_of(code, node.inputs[0]), code.constant(0))


def where(code: Assembler, node: RandomExpr, out: int) -> None:
    test, yes, no = node.inputs
    pick(code, out, test, [no, yes])


def as_radians(code: Assembler, node: RandomExpr, out: int) -> None:
    code.row(op.MULTIPLY, out, register_of(code, node.inputs[0]), code.constant(math.pi / 180))


def as_degrees(code: Assembler, node: RandomExpr, out: int) -> None:
    code.row(op.MULTIPLY, out, register_of(code, node.inputs[0]), code.constant(180 / math.pi))


def in_shape(code: Assembler, node: RandomExpr, out: int) -> None:
    """Whether a point lies in a fixed polygon: its edges stand in the operands."""
    import shapely

    assert isinstance(node.operation, Holds)
    x, y = node.inputs
    edges: list[float] = []
    for ring in shapely.get_rings(shapely.get_parts(node.operation.shape)):
        corners = shapely.get_coordinates(ring)
        edges += np.hstack([corners[:-1], corners[1:]]).ravel().tolist()
    if len(edges) > 4000:
        raise Unsupported("a region of more than 1000 edges cannot be asked for points")
    registers = (register_of(code, x), register_of(code, y), *(code.constant(each) for each in edges))
    code.row(op.IN_RINGS, out, 0, Operands(registers))


SPECIAL: tuple[tuple[Any, Callable[[Assembler, RandomExpr, int], None]], ...] = (
    (Table, choose_constant),
    (graph.pick, choose_value),
    (distributions.Cut, cut),
    (distributions.Integers, integers),
    (np.clip, clip),
    (graph.WHERE.array, where),
    (TRUE_OR_FALSE.array, as_truth),
    (np.radians, as_radians),
    (np.degrees, as_degrees),
    (Holds, in_shape),
)


def is_whole(value: Value) -> bool:
    """Whether a number is an integer, as Python would have it: it is written without a point."""
    if isinstance(value, RegisterValue):
        return value.whole
    if not isinstance(value, RandomExpr):
        return isinstance(value, int | np.integer) and not isinstance(value, bool)
    if isinstance(value, ThetaColumn):
        return False
    operation = value.operation
    if isinstance(operation, Table):
        return operation.options.dtype.kind == "i"
    if operation is graph.pick:
        return all(is_whole(each) for each in value.inputs[1:])
    if isinstance(operation, distributions.Cut | distributions.Integers):
        return True
    opcode = SIMPLE.get(operation) if _hashable(operation) else None
    if opcode in ALWAYS_WHOLE:
        return True
    return opcode in WHOLE and all(is_whole(each) for each in value.inputs)


# ------------------------------------------------------------ jumps

JUMPS: dict[Any, tuple[int, int, bool]] = {  # if it holds, if it does not, operands swapped
    graph.LESS.array: (op.JUMP_LESS, op.JUMP_NOT_LESS, False),
    graph.GREATER.array: (op.JUMP_LESS, op.JUMP_NOT_LESS, True),
    graph.LESS_EQUAL.array: (op.JUMP_LESS_EQUAL, op.JUMP_NOT_LESS_EQUAL, False),
    graph.GREATER_EQUAL.array: (op.JUMP_LESS_EQUAL, op.JUMP_NOT_LESS_EQUAL, True),
    graph.EQUAL.array: (op.JUMP_EQUAL, op.JUMP_NOT_EQUAL, False),
    graph.NOT_EQUAL.array: (op.JUMP_NOT_EQUAL, op.JUMP_EQUAL, False),
}


def jump(code: Assembler, test: Value, target: Label, when: bool) -> None:
    """Go to the target if the truth of `test` is `when`."""
    if not isinstance(test, RandomExpr):
        if bool(test) == when:
            code.row(op.JUMP, c=target)
        return
    operation = test.operation
    if operation is graph.NOT.array:
        jump(code, test.inputs[0], target, not when)
    elif _hashable(operation) and operation in JUMPS and is_live(test) and id(test) not in code.known:
        holds, fails, swapped = JUMPS[operation]
        left, right = (register_of(code, each) for each in test.inputs)
        left, right = (right, left) if swapped else (left, right)
        code.row(holds if when else fails, left, right, target)
    else:
        code.row(op.JUMP_IF if when else op.JUMP_UNLESS, register_of(code, test), c=target)
