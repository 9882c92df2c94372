"""How observations come to a GPU on which a student's weights are: step by step, each of them once.

A student acts on what it sees and later learns from it. So a rollout's observations are kept where the weights are, and
no copy of them is left to be made for the update. Read next: `learning.worker`, which sends them.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

BUFFERS = 2  # one is filled while what is in the other is on its way


class Upload:
    """Copies batches of one shape from the host to a GPU, by pinned buffers in turn, while the host goes on.

    A buffer is filled again only when the copy out of it has ended. Whatever the GPU is asked afterwards waits for the
    copies: they are in the order of its stream.

    Args:
        like: of the batches' shape and type.
    """

    def __init__(self, like: Tensor) -> None:
        self.buffers = [torch.empty(like.shape, dtype=like.dtype, pin_memory=True) for _ in range(BUFFERS)]
        self.copied = [torch.cuda.Event() for _ in range(BUFFERS)]
        self.turn = 0

    def __call__(self, batch: np.ndarray, place: Tensor) -> None:
        """Write a batch `[N, ...]` to its place on the GPU, in time for whatever that is asked next."""
        buffer, copied = self.buffers[self.turn], self.copied[self.turn]
        copied.synchronize()  # returns at once where nothing has been copied yet
        buffer.copy_(torch.as_tensor(batch))
        place.copy_(buffer, non_blocking=True)
        copied.record(torch.cuda.current_stream(place.device))
        self.turn = (self.turn + 1) % BUFFERS


def write(batch: np.ndarray, place: Tensor) -> None:
    """Write a batch to its place on the host."""
    place.copy_(torch.as_tensor(batch))
