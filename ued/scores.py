"""What a level is worth to a teacher, from the returns that students made on it.

Returns are undiscounted and of whole episodes. Read next: `methods.paired`.
"""

from __future__ import annotations

import numpy as np


def regret(protagonist: np.ndarray, antagonist: np.ndarray, rule: str, flexible: bool = False) -> np.ndarray:
    """Give the regret `[L]` of the protagonist on L levels, from both students' returns `[L, n]` of n episodes.

    rule: "max_mean" is max of the antagonist's returns minus mean of the protagonist's (Dennis et al. 2020,
    section 4.1, as implemented by its authors); "mean_mean" takes means of both, which equally good students make 0 on
    average where outcomes are random, while the maximum adds what luck alone can gain.
    flexible: on each level, whichever student did better by the rule's left side plays the antagonist's part.
    """
    best, other = _best(antagonist, rule), _best(protagonist, rule)
    gap = best - protagonist.mean(1)
    return np.where(best >= other, gap, other - antagonist.mean(1)) if flexible else gap


def _best(returns: np.ndarray, rule: str) -> np.ndarray:
    return returns.max(1) if rule == "max_mean" else returns.mean(1)
