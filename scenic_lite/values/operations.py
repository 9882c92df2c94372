"""The operations on numbers: one table, with all properties of an operation in one row.

A row contains the operation on Python's numbers (`scalar`, which raises Python's exceptions) and on arrays [N]
(`array`, which returns nan instead). It also contains the opcode of the virtual machine, whether the operation
preserves integers, and the test for failures. The `math` module of the language, the compiler's emitter and the checks
of arithmetic read this table. A new operation needs a row in this table. If a running match computes the operation, it
also needs a row in `dynamics.machine.opcodes` and a branch in `vm`. Read next: `values.graph`, which applies them.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenic_lite.values import formulas
from scenic_lite.values.formulas import TURN

KEPT, ALWAYS = "kept", "always"  # integer operands give an integer; the result is always an integer


@dataclass(frozen=True, eq=False, slots=True)
class Operation:
    """One operation. Operations outside the table have no opcode and no failure test.

    Attributes:
        scalar, array: the operation on numbers and on arrays [N].
        name: the name of the operation; for a function of Python's module `math`, the name in that module.
        arity: the number of operands; 0 means any number.
        opcode: the opcode of the virtual machine; "" if there is none.
        integers: KEPT, ALWAYS or ""; with "" the result counts as a fraction.
        fails: (result, *operands), arrays [N] -> [N] bool, the rows without a result; None: a result always exists.
        kind: the kind of the result, "number", "truth", "text" or "any".
        swapped: the opcode takes the two operands in reverse order.
    """

    scalar: Callable[..., Any]
    array: Callable[..., Any]
    name: str = ""
    arity: int = 0
    opcode: str = ""
    integers: str = ""
    fails: Callable[..., Any] | None = None
    kind: str = "number"
    swapped: bool = False


# ------------------------------------------------------------ where they fail
def zero_divisor(_result: Any, _dividend: Any, divisor: Any) -> Any:
    return np.asarray(divisor) == 0


def not_finite(result: Any, *operands: Any) -> Any:
    """Return the rows in which finite operands give no finite result; infinite operands do not count."""
    mask = is_infinite(result)
    for operand in operands:
        mask = mask & ~is_infinite(operand)
    return mask


def is_infinite(values: Any) -> Any:
    """Return the rows in which a number is infinite or NaN; False for other kinds of values."""
    array = np.asarray(values)
    return ~np.isfinite(array) if array.dtype.kind == "f" else np.zeros(array.shape, dtype=bool)


# ------------------------------------------------------------ implementations
def array_power(base: Any, exponent: Any) -> Any:
    """Return powers: integers for integer bases with a fixed integer exponent from 0, otherwise fractions."""
    if isinstance(exponent, int) and exponent >= 0 and base.dtype.kind == "i":
        return np.power(base, exponent)
    return np.float_power(base, exponent)


def real_power(base: Any, exponent: Any) -> Any:
    """Return `base ** exponent`. Raises ValueError if the result is not a real number, as for (-2) ** 0.5."""
    result = base**exponent
    if isinstance(result, complex):
        raise ValueError(f"({base:g}) ** {exponent:g} is not a real number")
    return result


def array_round(value: Any) -> Any:
    return to_integers(np.rint(value))


def to_integers(value: Any) -> Any:
    """Truncate to int64; numbers that are not finite become the least int64."""
    return np.where(np.isfinite(value), value, -(2.0**63)).astype(np.int64)


def array_select(index: Any, *options: Any) -> Any:
    """Return options[index] row by row; index [N], each option a scalar or [N]."""
    stacked = np.stack([np.broadcast_to(option, index.shape) for option in options])  # [K, N]
    return stacked[index, np.arange(len(index))]


def quietly(function: Callable[..., Any], kind: Callable[[Any], Any]) -> Callable[..., Any]:
    """Return a version of an array function for numbers, without NumPy's warnings about infinite numbers."""

    def of_numbers(*numbers: Any) -> Any:
        with np.errstate(all="ignore"):
            return kind(function(*numbers))

    return of_numbers


# fmt: off
# ------------------------------------------------------------ the table: signs
ADD = Operation(operator.add, np.add, "add", 2, "ADD", KEPT)
SUBTRACT = Operation(operator.sub, np.subtract, "subtract", 2, "SUBTRACT", KEPT)
MULTIPLY = Operation(operator.mul, np.multiply, "multiply", 2, "MULTIPLY", KEPT)
DIVIDE = Operation(operator.truediv, np.true_divide, "divide", 2, "DIVIDE", "", zero_divisor)
FLOOR_DIVIDE = Operation(operator.floordiv, np.floor_divide, "floor divide", 2, "FLOOR_DIVIDE", KEPT, zero_divisor)
MODULO = Operation(operator.mod, np.mod, "modulo", 2, "MODULO", KEPT, zero_divisor)
POWER = Operation(real_power, array_power, "power", 2, "POWER", "", not_finite)
NEGATE = Operation(operator.neg, np.negative, "negate", 1, "NEGATE", KEPT)
ABSOLUTE = Operation(abs, np.absolute, "abs", 1, "ABSOLUTE", KEPT)
MINIMUM = Operation(min, np.minimum, "min", 2, "MINIMUM", KEPT)
MAXIMUM = Operation(max, np.maximum, "max", 2, "MAXIMUM", KEPT)
# ------------------------------------------------------------ truth
LESS = Operation(operator.lt, np.less, "less", 2, "LESS", kind="truth")
LESS_EQUAL = Operation(operator.le, np.less_equal, "not greater", 2, "LESS_EQUAL", kind="truth")
GREATER = Operation(operator.gt, np.greater, "greater", 2, "LESS", kind="truth", swapped=True)
GREATER_EQUAL = Operation(operator.ge, np.greater_equal, "not less", 2, "LESS_EQUAL", kind="truth", swapped=True)
EQUAL = Operation(operator.eq, np.equal, "equal", 2, "EQUAL", kind="truth")
NOT_EQUAL = Operation(operator.ne, np.not_equal, "not equal", 2, "NOT_EQUAL", kind="truth")
AND = Operation(lambda a, b: bool(a) and bool(b), np.logical_and, "and", 2, "AND", kind="truth")
OR = Operation(lambda a, b: bool(a) or bool(b), np.logical_or, "or", 2, "OR", kind="truth")
NOT = Operation(operator.not_, np.logical_not, "not", 1, "NOT", kind="truth")
TRUTH = Operation(bool, lambda value: np.asarray(value) != 0, "bool", 1, kind="truth")
IS_NAN = Operation(math.isnan, np.isnan, "isnan", 1, kind="truth")
IS_INFINITE = Operation(math.isinf, np.isinf, "isinf", 1, kind="truth")
IS_FINITE = Operation(math.isfinite, np.isfinite, "isfinite", 1, kind="truth")
# ------------------------------------------------------------ choices
WHERE = Operation(lambda c, a, b: a if c else b, np.where, "where", 3)
SELECT = Operation(lambda index, *options: options[index], array_select, "select")
CLIP = Operation(lambda x, low, high: min(max(x, low), high), np.clip, "clip", 3)
# ------------------------------------------------------------ kinds of numbers
INTEGER = Operation(int, to_integers, "int", 1, "TRUNCATE", ALWAYS)
FLOAT = Operation(float, lambda value: np.asarray(value, dtype=float), "float", 1, "COPY")
ROUND = Operation(round, array_round, "round", 1, "ROUND", ALWAYS)
FLOOR = Operation(math.floor, lambda x: to_integers(np.floor(x)), "floor", 1, "FLOOR", ALWAYS)
CEILING = Operation(math.ceil, lambda x: to_integers(np.ceil(x)), "ceil", 1, "CEILING", ALWAYS)
# ------------------------------------------------------------ functions of one number
SQUARE_ROOT = Operation(math.sqrt, np.sqrt, "sqrt", 1, "SQUARE_ROOT", "", not_finite)
FLOAT_ABSOLUTE = Operation(math.fabs, np.fabs, "fabs", 1, "ABSOLUTE")
EXPONENTIAL = Operation(math.exp, np.exp, "exp", 1, "EXPONENTIAL", "", not_finite)
LOGARITHM = Operation(math.log, np.log, "log", 1, "LOGARITHM", "", not_finite)
LOGARITHM_2 = Operation(math.log2, np.log2, "log2", 1, "", "", not_finite)
LOGARITHM_10 = Operation(math.log10, np.log10, "log10", 1, "", "", not_finite)
SINE = Operation(math.sin, np.sin, "sin", 1, "SINE")
COSINE = Operation(math.cos, np.cos, "cos", 1, "COSINE")
TANGENT = Operation(math.tan, np.tan, "tan", 1)
ARC_SINE = Operation(math.asin, np.arcsin, "asin", 1, "", "", not_finite)
ARC_COSINE = Operation(math.acos, np.arccos, "acos", 1, "", "", not_finite)
ARC_TANGENT = Operation(math.atan, np.arctan, "atan", 1)
RADIANS = Operation(math.radians, np.radians, "radians", 1)
DEGREES = Operation(math.degrees, np.degrees, "degrees", 1)
NORMALISE = Operation(
    lambda angle: angle - TURN * round(angle / TURN), lambda angle: angle - TURN * np.rint(angle / TURN),
    "normalise", 1, "NORMALISE")
NORMAL_CDF = Operation(formulas.normal_cdf, formulas.normal_cdfs, "normal cdf", 1)
NORMAL_QUANTILE = Operation(
    quietly(formulas.normal_quantile, float), formulas.normal_quantile, "normal quantile", 1, "QUANTILE")
# ------------------------------------------------------------ functions of two numbers
HYPOTENUSE = Operation(math.hypot, np.hypot, "hypot", 2, "HYPOTENUSE")
ARC_TANGENT_2 = Operation(math.atan2, np.arctan2, "atan2", 2, "ARC_TANGENT_2")
COPY_SIGN = Operation(math.copysign, np.copysign, "copysign", 2)
FLOAT_MODULO = Operation(math.fmod, np.fmod, "fmod", 2, "", "", not_finite)
FLOAT_POWER = Operation(math.pow, np.float_power, "pow", 2, "POWER", "", not_finite)
REMAINDER = Operation(math.remainder, lambda x, y: x - y * np.rint(x / y), "remainder", 2, "", "", not_finite)
# ------------------------------------------------------------ the plane
IN_SECTOR = Operation(quietly(formulas.in_sector, bool), formulas.in_sector, "in sector", 5, "IN_SECTOR", kind="truth")
IN_RECTANGLE = Operation(
    quietly(formulas.in_rectangle, bool), formulas.in_rectangle, "in rectangle", 7, "IN_RECTANGLE", kind="truth")
RECTANGLES_MEET = Operation(
    quietly(formulas.rectangles_meet, bool), formulas.rectangles_meet, "rectangles meet", 10, "RECTANGLES_MEET",
    kind="truth")
SECTOR_MEETS = Operation(
    quietly(formulas.sector_meets_rectangle, bool), formulas.sector_meets_rectangle, "sector meets rectangle", 10,
    "SECTOR_MEETS", kind="truth")
# fmt: on

# Functions of one number that only programs call; functions that are always finite have no failure test.
RARER = ["cbrt", "exp2", "expm1", "log1p", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"]
OPERATIONS = (
    *(constant for constant in list(globals().values()) if isinstance(constant, Operation)),
    *(Operation(vars(math)[name], vars(np)[name], name, 1, fails=not_finite) for name in RARER),
)
_ROWS: dict[Any, Operation] = {operation.array: operation for operation in OPERATIONS}


def row_of(array: Any) -> Operation | None:
    """Return the row of the table with this array function, or None."""
    return _ROWS.get(array)
