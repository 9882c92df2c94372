"""The forward pass of a network, `ued.core.compiled.Network`, on 16 rows: weights and a table of layers define it.

The table is data, so one compiled kernel runs every network. Read next: `rollout.policy`.
"""

from __future__ import annotations

from regista.kernels.jit import kernel
from regista.kernels.rollout.lanes import LANES, logistic_at, tanh_at, tile_of_1, tile_of_2, tile_of_4, tile_of_8


@kernel
def run_network(weights, layers, state, scratch):
    """Run `layers`, LAYER `[L]`, on the inputs in `scratch[0]`; return the row of `scratch` that holds the outputs.

    `weights` `[W]` contains the weights of all layers. `state`, a GRU's hidden state `[H, 16]` flat, is updated.
    """
    at, number = 0, 0
    while number < len(layers):
        layer = layers[number]
        if layer.gru:
            linear(weights, layer, scratch[at], scratch[3])
            linear(weights, layers[number + 1], state, scratch[4])
            _update_gru(scratch[3], scratch[4], state, scratch[2])
            at, number = 2, number + 2
            continue
        to = 1 - at % 2
        linear(weights, layer, scratch[at], scratch[to])
        if layer.tanh:
            for i in range(layer.outputs):
                tanh_at(scratch[to], LANES * i)
        at, number = to, number + 1
    return at


@kernel
def linear(weights, layer, x, y):
    """Compute y = W x + b of a layer."""
    matrix, bias, inputs, outputs = layer.matrix, layer.bias, layer.inputs, layer.outputs
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
def _update_gru(read, recalled, state, out):
    """Update the `state` of a GRU and copy it to `out`; see `ued.learning.memory.GRU`.

    `read` and `recalled`, `[3 H, 16]` flat, are the linear maps of the inputs and of the state for the reset gate,
    the update gate and the candidate.
    """
    gate = len(state)  # number of entries of each gate and of the candidate
    for i in range(2 * gate):
        read[i] += recalled[i]
    for i in range(0, 2 * gate, LANES):
        logistic_at(read, i)
    for i in range(gate):
        read[2 * gate + i] += read[i] * recalled[2 * gate + i]
    for i in range(2 * gate, 3 * gate, LANES):
        tanh_at(read, i)
    for i in range(gate):
        new = read[2 * gate + i]
        state[i] = new + read[gate + i] * (state[i] - new)
        out[i] = state[i]
