"""What a step is worth to the learner: goals, and the checkpoints on the way to the opponents' goal.

Read next: `batch`.
"""

from __future__ import annotations

from scenic_lite.jit import kernel


@kernel
def reward(match, checkpoints):
    """Reward of the left team for the last step: +1 or -1 for a goal, and if asked 0.1 per checkpoint newly passed."""
    if checkpoints:
        return match.goal + match.checkpoint_reward
    return float(match.goal)
