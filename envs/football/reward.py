"""What a step is worth to the learner: goals, checkpoints on the way to the opponents' goal, what the program pays.

Read next: `batch`.
"""

from __future__ import annotations

from scenic_lite.jit import kernel


@kernel
def reward(match, checkpoints):
    """Reward of the left team for the last step: +1 or -1 for a goal, and if asked 0.1 per checkpoint newly passed.

    To that is added what the program's monitors have set `scenic_reward` to in this step.
    """
    if checkpoints:
        return match.goal + match.checkpoint_reward + match.program_reward
    return match.goal + match.program_reward
