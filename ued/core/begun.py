"""A check for environments that step many matches or mazes at once: each must have been reset.

Read next: `upomdp`, whose `reset` can select some environments.
"""

from __future__ import annotations

import numpy as np


def check_begun(begun: np.ndarray, what: str) -> None:
    """Raise RuntimeError unless all environments, bool `[k]`, have been reset at least once."""
    if not begun.all():
        some = "" if not begun.any() else f"; {np.count_nonzero(~begun)} of {len(begun)} environments were never reset"
        raise RuntimeError(f"call reset() before {what}{some}")
