"""Tests of the arithmetic in compiled rollouts, against NumPy in double precision."""

from __future__ import annotations

import numpy as np
import pytest

from regista.kernels.calls import compiles
from regista.kernels.jit import kernel

if not compiles():
    pytest.skip("vector instructions exist only in compiled kernels", allow_module_level=True)

from regista.kernels.rng import start_of, stream
from regista.kernels.rollout.lanes import LANES, exp_at, logistic_at, tanh_at
from regista.kernels.rollout.network import linear
from ued.core import compiled


@kernel
def exp_all(values):
    for at in range(0, len(values), LANES):
        exp_at(values, at)


@kernel
def tanh_all(values):
    for at in range(0, len(values), LANES):
        tanh_at(values, at)


@kernel
def logistic_all(values):
    for at in range(0, len(values), LANES):
        logistic_at(values, at)


@kernel
def compute(weights, layers, x, y):
    linear(weights, layers[0], x, y)


@kernel
def starts_of(seeds, starts):
    for i in range(len(seeds)):
        starts[i] = start_of(seeds[i])


def spread_out(largest: float) -> np.ndarray:
    """Return float32 numbers of both signs and all magnitudes up to `largest`, with both zeros and both limits."""
    rng = np.random.default_rng(0)
    sizes = np.concatenate([largest * rng.random(40_000), np.exp(rng.uniform(-40, np.log(largest), 40_000))])
    numbers = np.concatenate([sizes, -sizes, [0.0, -0.0, largest, -largest]]).astype(np.float32)
    return np.concatenate([numbers, np.zeros(-len(numbers) % LANES, np.float32)])


def test_the_processor_block_has_the_size_that_records_assume():
    assert LANES == compiled.LANES


def test_exp_has_a_relative_error_below_2e_7():
    x = spread_out(80.0)
    y = x.copy()
    exp_all(y)
    exact = np.exp(x.astype(np.float64))
    assert np.abs(y / exact - 1).max() < 2e-7


@pytest.mark.parametrize(
    ("function", "exact"),
    [(tanh_all, np.tanh), (logistic_all, lambda x: 1 / (1 + np.exp(-x)))],
    ids=["tanh", "logistic"],
)
def test_activations_have_an_absolute_error_below_2e_7(function, exact):
    x = np.concatenate([spread_out(20.0), spread_out(3e38)])
    y = x.copy()
    function(y)
    with np.errstate(over="ignore"):
        assert np.abs(y - exact(x.astype(np.float64))).max() < 2e-7


def test_activations_keep_nan():
    for function in (tanh_all, logistic_all, exp_all):
        x = np.full(LANES, np.nan, np.float32)
        function(x)
        assert np.isnan(x).all()


@pytest.mark.parametrize("outputs", [1, 2, 3, 7, 8, 13, 64])
@pytest.mark.parametrize("inputs", [1, 5, 115])
def test_a_linear_layer(inputs, outputs):
    rng = np.random.default_rng(inputs)
    weights, bias = rng.normal(size=(outputs, inputs)), rng.normal(size=outputs)
    x, y = rng.normal(size=(inputs, LANES)), np.zeros((outputs + 1, LANES), np.float32)
    flat = np.concatenate([[0.0], weights.ravel(), bias]).astype(np.float32)
    layer = np.array([(False, False, 1, 1 + weights.size, inputs, outputs)], compiled.LAYER).view(np.recarray)
    compute(flat, layer, x.astype(np.float32).ravel(), y.reshape(-1))
    np.testing.assert_allclose(y[:-1], weights @ x + bias[:, None], atol=1e-5 * np.sqrt(inputs))
    assert (y[-1] == 0).all()  # nothing is written beyond the outputs


def test_streams_start_as_in_python():
    seeds = np.array([0, 1, 2**31, 2**63, 2**64 - 1, 0x61C8864680B583EB], np.uint64)
    starts = np.zeros(len(seeds), np.uint64)
    starts_of(seeds, starts)
    assert starts.tolist() == [stream(seed) for seed in seeds.tolist()]
