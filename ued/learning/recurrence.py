"""The GRU of a batch of sequences, computed by episode, with its gradient in closed form.

Sequences are split where episodes start. All resulting segments are computed in parallel, the longest first. So the
loop over steps is as long as the longest segment, and each step is one matrix product for all segments with that step:

    step 0   a b c d        4 segments of 4, 3, 1 and 1 steps;
    step 1   a b            rows lie in this order: step by step, the segments that are left
    step 2   a b
    step 3   a

The loop has only the operations that depend on the previous state: 5 for a step, and 3 for its gradient. Products with
inputs, and the gradients of all weights, are single products over all rows. On one CPU core, 256 steps of 16
environments and their gradient take 37 ms at 128 units and 17 ms at 64 units. A loop of cells with autograd takes 59
and 35 ms. torch's GRU on packed sequences takes 5 to 8 times as long as this module. Read next: `learning.memory`,
which uses it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor

TANH_BACKWARD: Any = torch.ops.aten.tanh_backward  # gradient, tanh(x) -> gradient * (1 - tanh(x) ** 2)
SIGMOID_BACKWARD: Any = torch.ops.aten.sigmoid_backward  # gradient, σ(x) -> gradient * σ(x) * (1 - σ(x))


class Segments(NamedTuple):
    """The packing of S segments with R steps in total.

    Attributes:
        rows: `[R]` the row in the batch of each packed row.
        places: `[R]` the packed row of each row in the batch.
        first: `[S]` the row of the first step of each segment in the batch without omitted rows.
        counts: the number of segments with a step k, for each k.
    """

    rows: Tensor
    places: Tensor
    first: Tensor
    counts: list[int]


def segments(episode_starts: Tensor, kept: Tensor | None = None) -> Segments:
    """Return the segments of sequences in which episodes start at these steps, bool `[L, B]`.

    Step t of sequence b is row t * B + b. Only the steps `kept` `[L, B]`, the first ones of each segment, have rows;
    None: all steps.
    """
    length, envs = episode_starts.shape
    begins = episode_starts.T.cpu().clone()  # [B, L], since the steps of a segment are consecutive there
    begins[:, 0] = True
    steps = torch.arange(length * envs) if kept is None else kept.T.cpu().flatten().nonzero()[:, 0]  # [R]
    begin = begins.flatten()[steps].nonzero()[:, 0]  # [S]
    lengths = torch.diff(begin, append=begin.new_tensor([len(steps)]))
    lengths, order = lengths.sort(descending=True, stable=True)
    begin = begin[order]
    counts = len(lengths) - torch.bincount(lengths).cumsum(0)[:-1]  # [longest]
    step = torch.arange(len(counts)).repeat_interleave(counts)  # [R]
    segment = torch.arange(len(steps)) - (counts.cumsum(0) - counts).repeat_interleave(counts)  # [R]
    rows, first = (at % length * envs + at // length for at in (steps[begin[segment] + step], steps[begin]))
    if kept is not None:
        rows = (kept.cpu().flatten().cumsum(0) - 1)[rows]
    places = torch.empty_like(rows)
    places[rows] = torch.arange(len(rows))
    device = episode_starts.device
    return Segments(rows.to(device), places.to(device), first.to(device), counts.tolist())


def steps_to_learn(train: Tensor, episode_starts: Tensor) -> Tensor:
    """Return the steps of the mask `train` and all steps on which they depend: bool `[L, B]`, like both masks."""
    length, envs = train.shape
    segment = episode_starts.cumsum(0) + (length + 1) * torch.arange(envs, device=train.device)  # [L, B]
    time = torch.arange(length, device=train.device)[:, None].expand_as(segment)
    last = torch.full(((length + 1) * envs,), -1, device=train.device)
    last.scatter_reduce_(0, segment[train], time[train], "amax")
    return time <= last[segment]


class Recurrence(torch.autograd.Function):
    """The states of a GRU (Cho et al. 2014, in cuDNN's form) after the steps of packed segments.

    From features x, the state h before a step, and the weights of `read` (V, c) and `recall` (W, b):

        r, z, n = V x + c,  r', z', n' = W h + b          reset gate, keep gate, candidate
        r = σ(r + r'),  z = σ(z + z'),  n = tanh(n + r n')
        h ← (1 - z) n + z h

    `apply(features, start, V, c, W, b, segments)` takes features `[R, F]`, initial states `[S, H]` of the segments, and
    weights `[3 H, F]`, `[1, 3 H]`, `[3 H, H]` and `[1, 3 H]`. It returns states `[R, H]` in the order of the batch,
    like features. For several policies all arrays have a leading policy axis.
    """

    @staticmethod
    def forward(ctx: Any, features: Tensor, start: Tensor, *weights_and_segments: Any) -> Tensor:
        read_weight, read_bias, weight, bias, packed = weights_and_segments
        size, counts = start.shape[-1], packed.counts
        features = features.index_select(-2, packed.rows)
        read = _product(features)(read_bias, features, read_weight.mT)  # [R, 3 H]
        candidates = read[..., 2 * size :].clone(memory_format=torch.contiguous_format)  # below, read is overwritten
        states = torch.empty_like(candidates)
        # below, W h is added: the gates become r + r' and z + z', the last third n'
        gates, recalled = read.split((2 * size, size), -1)
        gates.add_(bias[..., : 2 * size])
        recalled.copy_(bias[..., 2 * size :].expand_as(recalled))
        buffers = read, gates, *gates.chunk(2, -1), recalled, candidates, states
        steps = zip(*(buffer.split(counts, -2) for buffer in buffers), strict=True)
        state, across = start, weight.mT.contiguous()  # transposed once, not in each product
        for count, (everything, both, reset, keep, remembered, candidate, after) in zip(counts, steps, strict=True):
            state = state.narrow(-2, 0, count)
            _add_product(everything, state, across)
            both.sigmoid_()
            candidate.addcmul_(reset, remembered).tanh_()
            state = torch.lerp(candidate, state, keep, out=after)
        ctx.save_for_backward(features, start, read_weight, weight, read, candidates, states)
        ctx.packed = packed
        return states.index_select(-2, packed.places)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, by_states: Tensor) -> tuple[Tensor | None, ...]:
        features, start, read_weight, weight, read, candidates, states = ctx.saved_tensors
        size, counts = start.shape[-1], ctx.packed.counts
        reset, keep, recalled = read.split(size, -1)
        blocks = states.split(counts, -2)
        before = [start, *(block.narrow(-2, 0, count) for block, count in zip(blocks, counts[1:], strict=False))]
        previous = torch.cat(before, -2)  # [R, H], the state before each step
        # derivatives of each state with respect to the argument of the tanh, and to r', z', n'
        to_candidate = TANH_BACKWARD(1 - keep, candidates)
        factors = torch.empty_like(read)
        by_reset, by_keep, by_recalled = factors.split(size, -1)
        by_reset.copy_(SIGMOID_BACKWARD(to_candidate * recalled, reset))
        by_keep.copy_(SIGMOID_BACKWARD(previous - candidates, keep))
        torch.mul(to_candidate, reset, out=by_recalled)
        flow = by_states.index_select(-2, ctx.packed.rows)  # the gradient of each state, to which later steps add
        by_start = torch.zeros_like(start)
        _through_time([by_start, *flow.split(counts, -2)], factors, keep, weight, counts)
        gradient = factors  # now of r', z', n'
        by_weight, by_bias = gradient.mT @ previous, gradient.sum(-2, keepdim=True)
        torch.mul(flow, to_candidate, out=gradient[..., 2 * size :])  # of r, z, n
        by_read_weight, by_read_bias = gradient.mT @ features, gradient.sum(-2, keepdim=True)
        by_features = (gradient @ read_weight).index_select(-2, ctx.packed.places)
        return by_features, by_start, by_read_weight, by_read_bias, by_weight, by_bias, None


def _through_time(
    flows: Sequence[Tensor], factors: Tensor, keep: Tensor, weight: Tensor, counts: Sequence[int]
) -> None:
    """Multiply the `factors` `[R, 3 H]`, derivatives of states by W h + b, by the gradients of these states, in place.

    `flows` has the gradients of the initial states, then the gradients `[counts[k], H]` of the states after each step.
    Contributions of later steps are added to them in place.
    """
    apart = factors.unflatten(-1, (3, -1))
    rows = factors.split(counts, -2), apart.split(counts, factors.ndim - 2), keep.split(counts, -2)
    for k, (row, factor, kept) in reversed(list(enumerate(zip(*rows, strict=True)))):
        flow, earlier = flows[k + 1], flows[k].narrow(-2, 0, counts[k])
        factor.mul_(flow.unsqueeze(-2))
        _add_product(earlier.addcmul_(flow, kept), row, weight)


def _product(features: Tensor) -> Any:
    """Return the function that multiplies and adds for one policy `[R, H]`, or several `[P, R, H]`."""
    return torch.addmm if features.ndim == 2 else torch.baddbmm


def _add_product(total: Tensor, left: Tensor, right: Tensor) -> None:
    """Add the product of two matrices, of each policy, in place."""
    (total.addmm_ if total.ndim == 2 else total.baddbmm_)(left, right)
