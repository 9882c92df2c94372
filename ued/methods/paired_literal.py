"""Literal PAIRED, as in Algorithm 1 (Dennis et al. 2020): the students also learn from regret.

    repeat
        the adversary proposes levels θ
        the protagonist plays them, and so does the antagonist
        regret of a level = return of the antagonist - return of the protagonist
        the adversary learns with reward regret, the antagonist with regret, the protagonist with -regret

It is a baseline for `methods.paired`. Students need the regret when they learn, so each level is played within one
rollout. Rollouts should be long enough for the episodes of a level: levels that are not finished in time are dropped.
Read next: `methods.repaired`.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from ued.config import PairedConfig, PairedLiteralConfig
from ued.learning.rollout import Rollout
from ued.levels.diagnostics import regret_split
from ued.levels.queue import LevelQueue
from ued.methods.method import Method
from ued.methods.paired import PairedCurriculum


class PairedLiteral(Method):
    """Trains a protagonist on -regret, an antagonist and an adversary on regret; see `Method` for the arguments.

    Raises:
        ValueError: if the environment has no free parameters, for normalized rewards, and for opponents, since regret
            is not defined for the second side.
    """

    def setup(self, config: PairedLiteralConfig | None, seed: int) -> None:
        if self.ppo.norm_reward:
            raise ValueError(
                "students learn from regret, not from rewards: use norm_reward=False (--no-norm-reward), or the method "
                "paired"
            )
        if self.upomdp.individual_rewards:
            raise ValueError("regret is that of the first side, so opponents cannot learn from it: use paired")
        self.config = PairedConfig(**vars(config or PairedLiteralConfig()), roles="dennis2020")
        self.curriculum = PairedCurriculum(self.upomdp, self.config, seed, self.budget)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs, max_lead=0)  # no new level within a rollout
        self.protagonist = self.add_learner("protagonist", self.upomdp)
        self.antagonist = self.add_learner("antagonist", self.upomdp.copy())

    def update(self) -> dict[str, float]:
        """Play one level of the adversary in each environment; let all three learn from regret."""
        self.queue.clear()  # open episodes are discarded
        for index, learner in enumerate(self.learners):
            learner.start(self.queue.first(index))
        self.fill_rollouts()
        finished = torch.as_tensor(self.queue.finished())  # [N], environments whose level both students have finished
        levels = self.queue.pop_finished()  # [L]
        metrics = self.curriculum.update(levels)  # the adversary learns from the regret of each level
        metrics |= regret_split(levels, has_antagonist=True)
        regret = levels["score"]  # [L]
        for learner, reward in ((self.protagonist, -regret), (self.antagonist, regret)):
            rollout = regret_as_reward(learner.rollout.columns(finished), reward)
            metrics |= learner.learn(self.env_steps, rollout=rollout)
        return self.report(levels, metrics)


def regret_as_reward(rollout: Rollout, reward: np.ndarray) -> Rollout:
    """Replace the rewards of L environments by `reward` `[L]` at the end of each episode, which terminates it."""
    ended: Tensor = rollout.terminated | rollout.truncated  # [T, L]
    rollout.reward = torch.where(ended, torch.tensor(reward.tolist()), 0.0)  # [T, L]
    rollout.terminated, rollout.truncated = ended, torch.zeros_like(ended)
    return rollout
