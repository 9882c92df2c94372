"""Statistics of the critic per episode, for scores that need values (max_mc, value losses).

Episodes can span several rollouts, so the sums of an open episode carry over. Advantages come from the critic at the
update of each step. The reference implementations of PLR do the same: they merge the parts of an episode, weighted by
their numbers of steps. Read next: `levels.scores`.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from ued.core.resumable import Resumable
from ued.core.upomdp import UPOMDP
from ued.learning.rollout import Rollout

NEGATIVE = "negative_advantage"  # the name of an optional sum
NAMES = ("mean_value", "positive_advantage", "absolute_advantage")


class EpisodeValues(Resumable):
    """Sums statistics over the episodes of N environments across rollouts.

    Args:
        num_envs: N.
        negative: whether to follow maximized negative advantages, too.
        agents: number of agents of each environment that count, from the first one on; None: all.
    """

    state_fields = ("sums", "steps")
    names: tuple[str, ...] = NAMES  # V of them

    def __init__(self, num_envs: int, negative: bool = False, agents: int | None = None) -> None:
        self.negative, self.agents = negative, agents
        self.sums = np.zeros((len(self.names) + negative, num_envs))  # over the steps of open episodes
        self.steps = np.zeros(num_envs, np.int64)

    def reset(self) -> None:
        """Discard the open episodes, after a reset of all environments."""
        self.sums[:] = 0.0
        self.steps[:] = 0

    def track(self, rollout: Rollout, advantages: Tensor, negative: Tensor | None = None) -> dict[str, np.ndarray]:
        """Add a rollout; return means over the steps of each of the E episodes that ended in it, `[E]` by name.

        Episodes are ordered by their last step, then by environment. `negative` are the `negative_advantages` of the
        rollout `[T, N]`, if they are followed; their sum is returned with its sign changed.
        """
        per_step = self.per_step(rollout, advantages)
        if negative is not None:
            per_step = torch.cat([per_step, -negative[None]])
        per_step = per_step.view(*per_step.shape[:3], -1)[..., : self.agents].mean(-1)  # over agents
        running = per_step.double().cumsum(1).numpy()  # [V, T, N], one more with `negative`
        ended = (rollout.terminated | rollout.truncated).numpy()  # [T, N]
        num_steps = len(ended)
        env, step = np.nonzero(ended.T)  # [E] each, by environment, then by step
        first = np.append(True, env[1:] != env[:-1])[: len(env)]  # [E] first of its environment in this rollout
        previous = np.roll(np.arange(len(env)), 1)
        totals = running[:, step, env]  # [V, E]
        sums = np.where(first, totals + self.sums[:, env], totals - totals[:, previous])
        steps = np.where(first, step + 1 + self.steps[env], step - step[previous])
        last = np.append(env[1:] != env[:-1], True)[: len(env)]
        self.sums += running[:, -1]
        self.steps += num_steps
        self.sums[:, env[last]] = running[:, -1, env[last]] - totals[:, last]
        self.steps[env[last]] = num_steps - 1 - step[last]
        order = np.lexsort((env, step))
        means = (sums[: len(self.names)] / steps)[:, order]
        found = dict(zip(self.names, means, strict=True))
        return found if negative is None else found | {NEGATIVE: sums[-1, order]}

    def per_step(self, rollout: Rollout, advantages: Tensor) -> Tensor:
        """Return the statistics of each step and agent: `[V, T, N]` or `[V, T, N, A]`."""
        return torch.stack([rollout.value, advantages.clamp(min=0.0), advantages.abs()])


def scored_agents(upomdp: UPOMDP) -> int | None:
    """Return the number of agents that score levels: those of the first side; None: all agents of one team."""
    return upomdp.first_side if upomdp.individual_rewards else None
