"""A network's forward pass on 16 rows, given by its weights and a table of its layers: `ued.core.compiled.Network`.

The table is data, so that no other network compiles anything anew. Read next: `rollout.policy`.
"""

from __future__ import annotations

from regista.kernels.jit import kernel
from regista.kernels.rollout.lanes import LANES, logistic_at, tanh_at, tile_of_1, tile_of_2, tile_of_4, tile_of_8


@kernel
def run_network(weights, layers, state, scratch):
    """Run `layers`, LAYER `[L]`, on the inputs in `scratch[0]`; return the row of `scratch` that holds the outputs.

    `weights` `[W]` are those of all layers. `state` `[H, 16]`, flat, of a GRU is updated.
    """
    at = 0
    for number in range(len(layers)):
        layer = layers[number]
        if layer.gru:
            _gru(weights, layer.matrix, layer.outputs, scratch[at], state, scratch)
            at = 2
        else:
            to = 1 - at % 2
            linear(weights, layer.matrix, layer.bias, layer.inputs, layer.outputs, scratch[at], scratch[to])
            if layer.tanh:
                for i in range(layer.outputs):
                    tanh_at(scratch[to], LANES * i)
            at = to
    return at


@kernel
def linear(weights, matrix, bias, inputs, outputs, x, y):
    """Compute y = W x + b; W `[outputs, inputs]` begins at entry `matrix` of the weights, b at entry `bias`."""
    j = 0
    while j + 8 <= outputs:
        tile_of_8(weights, matrix + j * inputs, bias + j, inputs, x, y, LANES * j)
        j += 8
    if j + 4 <= outputs:
        tile_of_4(weights, matrix + j * inputs, bias + j, inputs, x, y, LANES * j)
        j += 4
    if j + 2 <= outputs:
        tile_of_2(weights, matrix + j * inputs, bias + j, inputs, x, y, LANES * j)
        j += 2
    if j < outputs:
        tile_of_1(weights, matrix + j * inputs, bias + j, inputs, x, y, LANES * j)


@kernel
def _gru(weights, row, size, x, state, scratch):
    """Update the `state` of a GRU (see `ued.learning.memory.GRU`) and copy it into `scratch[2]`.

    Its weights are W, b of what it reads and W, b of what it recalls, each for reset, update and candidate.
    """
    read, recalled, out = scratch[3], scratch[4], scratch[2]
    square = 3 * size * size
    linear(weights, row, row + square, size, 3 * size, x, read)
    row += square + 3 * size
    linear(weights, row, row + square, size, 3 * size, state, recalled)
    gate, candidate = LANES * size, 2 * LANES * size
    for i in range(candidate):
        read[i] += recalled[i]
    for i in range(2 * size):
        logistic_at(read, LANES * i)
    for i in range(gate):
        read[candidate + i] += read[i] * recalled[candidate + i]
    for i in range(size):
        tanh_at(read, candidate + LANES * i)
    for i in range(gate):
        new = read[candidate + i]
        state[i] = new + read[gate + i] * (state[i] - new)
        out[i] = state[i]
