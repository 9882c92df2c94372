"""Independent random streams from one seed, so that nothing is drawn from a global generator.

Read next: `methods.dr`, which begins with them.
"""

from __future__ import annotations

import numpy as np
import torch


def split_seed(seed: int, count: int) -> list[int]:
    """Give `count` seeds (63 bits) for streams that have nothing to do with one another."""
    return [int(child.generate_state(1, np.uint64)[0] >> 1) for child in np.random.SeedSequence(seed).spawn(count)]


def torch_stream(seed: int) -> torch.Generator:
    """Give a torch generator on the CPU with this seed."""
    return torch.Generator().manual_seed(seed)
