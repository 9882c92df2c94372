"""Arithmetic on vectors of 16 rows, as LLVM instructions: the inner loops of a forward pass.

An array of features holds 16 rows side by side, `[features, 16]`, flat: feature f of row r is entry 16 f + r. So one
vector register holds a feature of all rows (on processors with shorter registers, two or four). No product depends on
the arrangement of loops by a compiler. A matrix product keeps 8 outputs in registers while it iterates over the inputs;
each input costs one load and 8 multiplications.

exp is 2^n times a polynomial (Cody and Waite 1980): its relative error is below 2e-7. tanh and the logistic function
follow from it, with an absolute error below 2e-7. Read next: `rollout.network`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 16
_FLOAT, _INT, _SIZE = ir.FloatType(), ir.IntType(32), ir.IntType(64)
_VECTOR, _INTS = ir.VectorType(_FLOAT, LANES), ir.VectorType(_INT, LANES)
_ALIGN = 4  # bytes: NumPy's arrays of float32
_LOG2_E = 1 / math.log(2)
_LN2_HIGH = 0.693359375  # ln 2 in two parts: n times the first is exact in float32
_LN2_LOW = math.log(2) - _LN2_HIGH
_LARGEST = 87.0  # arguments of exp are clipped to this: the result fits into float32
_TERMS = 7  # degree of the power series of exp on [-ln 2 / 2, ln 2 / 2]
_BIAS, _MANTISSA = 127, 23  # of float32


class _Lanes:
    """Writes vector instructions with an LLVM builder."""

    def __init__(self, builder: Any) -> None:
        self.b = builder

    def constant(self, value: float) -> ir.Constant:
        return ir.Constant(_VECTOR, [float(value)] * LANES)

    def spread(self, number: Any) -> Any:
        """Return a number in all lanes."""
        undefined = ir.Constant(_VECTOR, ir.Undefined)
        first = self.b.insert_element(undefined, number, ir.Constant(_INT, 0))
        return self.b.shuffle_vector(first, undefined, ir.Constant(_INTS, [0] * LANES))

    def load(self, data: Any, index: Any) -> Any:
        return self.b.load(self._place(data, index), align=_ALIGN)

    def store(self, vector: Any, data: Any, index: Any) -> None:
        self.b.store(vector, self._place(data, index), align=_ALIGN)

    def _place(self, data: Any, index: Any) -> Any:
        return self.b.bitcast(self.b.gep(data, [index]), _VECTOR.as_pointer())

    def fma(self, a: Any, b: Any, c: Any) -> Any:
        """Return a * b + c, rounded once."""
        return self._call("llvm.fma.v16f32", a, b, c)

    def exp(self, x: Any) -> Any:
        """Return exp(x): 2^n exp(r) with x = n ln 2 + r."""
        for sign, beyond in ((1, ">"), (-1, "<")):  # comparisons that nan passes unchanged
            largest = self.constant(sign * _LARGEST)
            x = self.b.select(self.b.fcmp_ordered(beyond, x, largest), largest, x)
        n = self._call("llvm.nearbyint.v16f32", self.b.fmul(x, self.constant(_LOG2_E)))
        r = self.fma(n, self.constant(-_LN2_HIGH), x)
        r = self.fma(n, self.constant(-_LN2_LOW), r)
        series = self.constant(1 / math.factorial(_TERMS))
        for k in reversed(range(_TERMS)):
            series = self.fma(series, r, self.constant(1 / math.factorial(k)))
        power = self.b.add(self.b.fptosi(n, _INTS), ir.Constant(_INTS, [_BIAS] * LANES))
        power = self.b.shl(power, ir.Constant(_INTS, [_MANTISSA] * LANES))
        return self.b.fmul(series, self.b.bitcast(power, _VECTOR))

    def logistic(self, x: Any) -> Any:
        """Return 1 / (1 + exp(-x))."""
        one = self.constant(1)
        return self.b.fdiv(one, self.b.fadd(one, self.exp(self.b.fmul(x, self.constant(-1)))))

    def tanh(self, x: Any) -> Any:
        """Return 1 - 2 / (exp(2 x) + 1)."""
        grown = self.b.fadd(self.exp(self.b.fmul(x, self.constant(2))), self.constant(1))
        return self.b.fsub(self.constant(1), self.b.fdiv(self.constant(2), grown))

    def _call(self, name: str, *vectors: Any) -> Any:
        kind = ir.FunctionType(_VECTOR, [_VECTOR] * len(vectors))
        return self.b.call(cgutils.get_or_insert_function(self.b.module, kind, name), vectors)


def _data(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    """Return the address of an array's first entry."""
    return cgutils.create_struct_proxy(kind)(context, builder, array).data


def _in_place(function: Callable[[_Lanes, Any], Any]) -> Any:
    """Make an intrinsic that applies a function to 16 entries of an array, starting at an index, in place."""

    @intrinsic
    def replace(typing, array, index):
        def generate(context, builder, signature, arguments):
            lanes, data = _Lanes(builder), _data(context, builder, signature.args[0], arguments[0])
            lanes.store(function(lanes, lanes.load(data, arguments[1])), data, arguments[1])

        return types.void(array, types.int64), generate

    return replace


exp_at, logistic_at, tanh_at = map(_in_place, (_Lanes.exp, _Lanes.logistic, _Lanes.tanh))


def _tile(outputs: int) -> Any:
    """Make an intrinsic for a few outputs of a linear layer: y = W x + b.

    Its arguments are, in this order: the flat `weights`; `row` and `bias`, the indices in `weights` of the first
    output's row of W and of its bias; the number of inputs; `x` `[inputs, 16]`; `y` `[outputs, 16]`; and `at`, the
    index of the first output in y.
    """

    @intrinsic
    def tile(typing, weights, row, bias, inputs, x, y, at):
        size = types.int64
        signature = types.void(weights, size, size, size, x, y, size)

        def generate(context, builder, signature, arguments):
            weights, row, bias, inputs, x, y, at = arguments
            kinds = signature.args[0], signature.args[4], signature.args[5]
            data = [_data(context, builder, kind, array) for kind, array in zip(kinds, (weights, x, y), strict=True)]
            sums = _product(_Lanes(builder), data[:2], (row, bias, inputs), outputs)
            for i, total in enumerate(sums):
                _Lanes(builder).store(total, data[2], builder.add(at, ir.Constant(_SIZE, LANES * i)))

        return signature, generate

    return tile


def _product(lanes: _Lanes, data: Any, places: Any, outputs: int) -> list[Any]:
    """Write a tile's loop over its inputs (at least one); return the sums of its outputs."""
    (weights, x), (row, bias, inputs), b = data, places, lanes.b
    zero, one = ir.Constant(_SIZE, 0), ir.Constant(_SIZE, 1)
    rows = [b.add(row, b.mul(inputs, ir.Constant(_SIZE, i))) for i in range(outputs)]
    first = [lanes.spread(b.load(b.gep(weights, [b.add(bias, ir.Constant(_SIZE, i))]))) for i in range(outputs)]
    before, loop, after = b.block, b.append_basic_block("inputs"), b.append_basic_block("summed")
    b.branch(loop)
    b.position_at_end(loop)
    k, sums = b.phi(_SIZE), [b.phi(_VECTOR) for _ in range(outputs)]
    feature = lanes.load(x, b.mul(k, ir.Constant(_SIZE, LANES)))
    further = [
        lanes.fma(lanes.spread(b.load(b.gep(weights, [b.add(rows[i], k)]))), feature, sums[i]) for i in range(outputs)
    ]
    for phi, start, step in zip((k, *sums), (zero, *first), (b.add(k, one), *further), strict=True):
        phi.add_incoming(start, before)
        phi.add_incoming(step, loop)
    b.cbranch(b.icmp_signed("<", b.add(k, one), inputs), loop, after)
    b.position_at_end(after)
    return further


tile_of_8, tile_of_4, tile_of_2, tile_of_1 = map(_tile, (8, 4, 2, 1))
