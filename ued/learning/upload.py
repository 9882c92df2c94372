"""Copy each observation once to the GPU of a student's weights, step by step.

A student acts on an observation and later learns from it, so a rollout's observations are stored where the weights are.
This avoids a second copy of the whole rollout before each update, and the host does not wait for the copies. Read next:
`learning.worker`, which sends them.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

BUFFERS = 2  # one buffer is filled while the other is copied


class Upload:
    """Copies batches of one shape from the host to a GPU through two pinned buffers, without blocking the host.

    A buffer is reused only after its copy has ended. Later work on the GPU waits for the copies, since they are in the
    same stream.

    Args:
        like: a batch with the shape and dtype of all batches.
    """

    def __init__(self, like: Tensor) -> None:
        self.buffers = [torch.empty(like.shape, dtype=like.dtype, pin_memory=True) for _ in range(BUFFERS)]
        self.copied = [torch.cuda.Event() for _ in range(BUFFERS)]
        self.turn = 0

    def __call__(self, batch: np.ndarray, place: Tensor) -> None:
        """Write a batch `[N, ...]` to its place on the GPU, before any later work of the same stream."""
        buffer, copied = self.buffers[self.turn], self.copied[self.turn]
        copied.synchronize()  # returns at once before the first copy
        buffer.copy_(torch.as_tensor(batch))
        place.copy_(buffer, non_blocking=True)
        copied.record(torch.cuda.current_stream(place.device))
        self.turn = (self.turn + 1) % BUFFERS


def write(batch: np.ndarray, place: Tensor) -> None:
    """Write a batch to its place on the host."""
    place.copy_(torch.as_tensor(batch))
