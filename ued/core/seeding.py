"""Independent random streams from one seed, so that no code uses a global generator.

Read next: `methods.method`, which seeds a training run with them.
"""

from __future__ import annotations

import numpy as np
import torch


class SeedStream:
    """A sequence of seeds (63 bits) of independent random streams."""

    def __init__(self, seed: int) -> None:
        self._sequence = np.random.SeedSequence(seed)

    def next(self) -> int:
        """Return a seed that was not returned before."""
        return int(self._sequence.spawn(1)[0].generate_state(1, np.uint64)[0] >> 1)


def torch_generator(seed: int) -> torch.Generator:
    """Return a torch generator on the CPU with this seed."""
    return torch.Generator().manual_seed(seed)
