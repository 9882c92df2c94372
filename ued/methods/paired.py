"""PAIRED (Dennis et al. 2020, Algorithm 1): an adversary proposes levels on which one student beats another.

    repeat
        the adversary proposes levels θ
        the protagonist plays them, and so does the antagonist
        regret of a level = what the antagonist reached - what the protagonist reached
        the adversary learns to cause regret; both students learn from the rewards of the environment

A level that nobody can solve causes no regret, nor does one that both solve: what is left lies at the edge of what the
protagonist can do. Here a rollout is not cut to levels: `level_queue` says how whole episodes are made sure of.
Students learn from their own rewards, as in every implementation that works: from each student's view the other's
return is a constant. `student_reward="regret"` is the letter of the algorithm instead.
Read next: `level_queue`, `adversary`, `scores`.
"""

from __future__ import annotations

from enum import IntEnum
from time import perf_counter
from typing import Any

import numpy as np
import torch

from ued.adversary import Adversary, Proposals
from ued.config import PairedConfig, PPOConfig
from ued.level_queue import LevelQueue, entry_dtype
from ued.methods import LevelBatch, episode_metrics, prefixed
from ued.player import Player, collect
from ued.ppo import PPO
from ued.rollout import Rollout
from ued.scores import regret
from ued.streams import split_seed, torch_stream
from ued.student import Student
from ued.upomdp import UPOMDP

NAMES = ("protagonist", "antagonist")


class Origin(IntEnum):
    """Where a level in the queue comes from."""

    ADVERSARY = 0
    RANDOM = 1  # the admixture of domain randomisation
    REPLACED = 2  # random, in the place of a proposal that describes no valid level


class Paired:
    """Trains a protagonist and an antagonist on the levels of an adversary. A `Method`.

    Args:
        upomdp: the environments; they are reset and belong to this object from then on. The antagonist plays in a
            copy of them.
        ppo: how both students learn.
        config: the adversary, and what counts as regret.
        seed: of every random stream.

    Raises `ValueError` where the environment has no free parameters.
    """

    def __init__(
        self, upomdp: UPOMDP, ppo: PPOConfig | None = None, config: PairedConfig | None = None, seed: int = 0
    ) -> None:
        ppo, config = ppo or PPOConfig(), config or PairedConfig()
        levels, mix, adversary, *each = split_seed(seed, 9)
        self.config, self.upomdp = config, upomdp
        self.adversary = Adversary(upomdp.theta_dim, config.adversary, torch_stream(adversary))
        self.mix = np.random.default_rng(mix)
        self.entry = entry_dtype(
            upomdp.levels.dtype, upomdp.theta_dim, config.adversary.context_size, 2, config.episodes_per_level
        )
        max_lead = 0 if config.student_reward == "regret" else 2 * upomdp.num_envs
        self.queue = LevelQueue(self._supply, self.entry, upomdp.num_envs, max_lead)
        self.lessons = np.zeros(0, self.entry)  # settled levels that the adversary has yet to learn from
        self.updates = 0
        self.last: LevelBatch | None = None
        upomdp.reset(seed=levels)
        self.players = [
            self._player(0, upomdp, ppo, *each[:2]),
            self._player(1, upomdp.copy(), ppo, *each[2:4]),
        ]
        self.ppos = [
            PPO(player.student, ppo, torch_stream(s)) for player, s in zip(self.players, each[4:], strict=True)
        ]

    def _player(self, index: int, upomdp: UPOMDP, ppo: PPOConfig, weights: int, actions: int) -> Player:
        spaces = upomdp.single_observation_space, upomdp.single_action_space
        student = Student(*spaces, ppo, torch_stream(weights))
        player = Player(
            student,
            upomdp,
            ppo.num_steps,
            torch_stream(actions),
            lambda ended, returns: self.queue.renew(index, ended, returns),
        )
        player.start(self.queue.first(index))
        return player

    @property
    def student(self) -> Student:
        return self.players[0].student

    @property
    def students(self) -> dict[str, Student]:
        return {name: player.student for name, player in zip(NAMES, self.players, strict=True)}

    @property
    def env_steps(self) -> int:
        return sum(player.env_steps for player in self.players)

    def update(self) -> dict[str, float]:
        """Play the adversary's levels with both students; let all three learn."""
        if self.config.student_reward == "regret":
            self._begin_together()
        collect(self.players)
        counting = self.queue.settled()
        settled = self.queue.take_settled()
        began = perf_counter()
        self._judge(settled)
        metrics = self._teach(settled)
        taught = perf_counter()
        rollouts = [player.rollout for player in self.players]
        if self.config.student_reward == "regret":
            rollouts = self._pay_regret(rollouts, counting, settled["score"])
        for name, player, ppo, rollout in zip(NAMES, self.players, self.ppos, rollouts, strict=True):
            metrics |= episode_metrics(name, player.take_episodes())
            if rollout.reward.numel():
                metrics |= prefixed(name, ppo.learn(rollout, self.env_steps))
        learned = perf_counter()
        self.last = self._as_levels(settled)
        self.updates += 1
        return {
            "env_steps": float(self.env_steps),
            "updates": float(self.updates),
            **metrics,
            **self._level_metrics(settled),
            **prefixed("time", self._seconds() | {"adversary": taught - began, "learn": learned - taught}),
        }

    # ------------------------------------------------------------ levels

    def _supply(self, count: int) -> np.ndarray:
        """Give `count` new entries of the queue: the adversary's, some random ones among them."""
        entries = np.zeros(count, self.entry)
        proposals = self.adversary.propose(count)
        entries["z"], entries["raw"], entries["log_prob"] = proposals.z, proposals.raw, proposals.log_prob
        theta = proposals.theta
        entries["level"] = self.upomdp.make_levels(theta)
        entries["origin"][~self.upomdp.valid(theta)] = Origin.REPLACED
        entries["origin"][self.mix.random(count) < self.config.dr_fraction] = Origin.RANDOM
        random = entries["origin"] != Origin.ADVERSARY
        entries["level"][random] = self.upomdp.sample_levels(int(random.sum()))
        return entries

    def _judge(self, settled: np.ndarray) -> None:
        """Write the score of each settled level: its regret."""
        config, returns = self.config, settled["returns"]  # [L, 2, n]
        score = regret(returns[:, 0], returns[:, 1], config.regret, config.flexible)
        settled["score"] = np.maximum(score, 0.0) if config.clip_regret else score

    def _teach(self, settled: np.ndarray) -> dict[str, float]:
        """Let the adversary learn from its own proposals, once enough of them are settled."""
        lessons = settled[settled["origin"] == Origin.ADVERSARY]
        if self.config.invalid_penalty:
            refused = settled[settled["origin"] == Origin.REPLACED]  # what was played in their place is not theirs
            refused["score"] = -self.config.invalid_penalty
            lessons = np.concatenate([lessons, refused])
        self.lessons = np.concatenate([self.lessons, lessons])
        if len(self.lessons) < self.config.adversary.min_batch:
            return {}
        proposals = Proposals(*(np.ascontiguousarray(self.lessons[name]) for name in ("z", "raw", "log_prob")))
        losses = self.adversary.learn(proposals, self.lessons["score"])
        self.lessons = self.lessons[:0]
        self.queue.drop_untaken()
        return prefixed("adversary", losses)

    # ------------------------------------------------------------ the letter of the algorithm

    def _begin_together(self) -> None:
        """Give every environment of both students a new level at once; its unfinished episode is lost.

        Regret as a reward must be known when students learn, so here a level lives in one rollout, which should be
        long enough for its episodes: environments in which it is not contribute nothing.
        """
        self.queue.clear()
        for index, player in enumerate(self.players):
            player.start(self.queue.first(index))

    def _pay_regret(self, rollouts: list[Rollout], counting: np.ndarray, score: np.ndarray) -> list[Rollout]:
        """Replace rewards: at the end of every episode -regret for the protagonist, regret for the antagonist.

        `counting` (bool `[N]`) are the environments whose level is settled, `score` the regrets of these levels.
        """
        paid = []
        for rollout, sign in zip(rollouts, (-1.0, 1.0), strict=True):
            mine = rollout.columns(torch.as_tensor(counting))
            ended = mine.terminated | mine.truncated
            mine.reward = torch.where(ended, sign * torch.tensor(score.tolist()), 0.0)
            mine.terminated, mine.truncated = ended, torch.zeros_like(ended)  # regret is all there is
            paid.append(mine)
        return paid

    # ------------------------------------------------------------ what is told

    def _as_levels(self, settled: np.ndarray) -> LevelBatch:
        count = np.full(len(settled), self.config.episodes_per_level)
        return LevelBatch(
            theta=settled["level"]["theta"],
            returns={name: settled["returns"][:, s].mean(1) for s, name in enumerate(NAMES)},
            episodes=dict.fromkeys(NAMES, count),
            score=settled["score"],
        )

    def _level_metrics(self, settled: np.ndarray) -> dict[str, float]:
        """Give counts of levels, and regret split into skill (difference of means) and luck (the rest)."""
        counts = np.bincount(settled["origin"], minlength=len(Origin))
        metrics = {
            "levels": float(len(settled)),
            "levels/random": float(counts[Origin.RANDOM]),
            "levels/invalid": float(counts[Origin.REPLACED]),
            "levels/open": float(len(self.queue.entries)),
        }
        own = settled[settled["origin"] == Origin.ADVERSARY]
        if len(own):
            skill = float((own["returns"][:, 1] - own["returns"][:, 0]).mean())
            mean = float(own["score"].mean())
            metrics |= {"regret": mean, "regret/skill": skill, "regret/luck": mean - skill}
            metrics["theta_std"] = float(own["level"]["theta"].std(0).mean())
        return metrics

    def _seconds(self) -> dict[str, float]:
        each = [player.take_seconds() for player in self.players]
        return {name: sum(seconds[name] for seconds in each) for name in each[0]}

    # ------------------------------------------------------------ save and resume

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Give everything that changes; without `episodes`, all but the state of the environments."""
        return {
            "players": [player.state_dict(episodes) for player in self.players],
            "ppos": [ppo.state_dict() for ppo in self.ppos],
            "adversary": self.adversary.state_dict(),
            "queue": self.queue.state_dict(),
            "lessons": self.lessons.copy(),
            "mix": self.mix.bit_generator.state,
            "updates": self.updates,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        for player, saved in zip(self.players, state["players"], strict=True):
            player.load_state_dict(saved)
        for ppo, saved in zip(self.ppos, state["ppos"], strict=True):
            ppo.load_state_dict(saved)
        self.adversary.load_state_dict(state["adversary"])
        self.queue.load_state_dict(state["queue"])
        self.lessons = state["lessons"].copy()
        self.mix.bit_generator.state = state["mix"]
        self.updates = state["updates"]
