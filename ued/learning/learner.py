"""A learner: a student with its rollout worker and its PPO.

Read next: `methods.method`, in which one or more learners play the same levels.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from time import perf_counter
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Discrete

from ued.config import PPOConfig
from ued.core.seeding import SeedStream, torch_generator
from ued.core.upomdp import UPOMDP
from ued.learning.compiled import CompiledWorker
from ued.learning.kl import AnnealedKL, KLRegularizer
from ued.learning.ppo import PPO
from ued.learning.reward_scale import RewardScale
from ued.learning.rollout import Rollout, gae, negative_advantages
from ued.learning.student import Student
from ued.learning.upload import Upload
from ued.learning.value_stats import EpisodeValues, scored_agents
from ued.learning.worker import Episodes, OnEpisodeEnd

RECENT = 100  # episodes of a rolling return


class Learner:
    """A student, its rollout worker, and its PPO.

    Args:
        name: prefix of its metrics.
        upomdp: N environments, used by this learner only.
        config: settings of the student and of PPO.
        seeds: for its weights, its actions, and the shuffling of minibatches, in this order.
        on_episode_end: selects the next level of an environment; see `RolloutWorker`.
        scripted: whether the environments play a scripted policy; then there is no student and no learning.

    Attributes:
        rewards: normalizes rewards; None: the student learns from raw rewards.

    Raises `ValueError` for opponents with a central critic.
    """

    def __init__(
        self,
        name: str,
        upomdp: UPOMDP,
        config: PPOConfig,
        seeds: SeedStream,
        on_episode_end: OnEpisodeEnd,
        scripted: bool = False,
    ) -> None:
        if upomdp.individual_rewards and config.critic == "central":
            raise ValueError("opponents have different values, so they need critic='own' (--critic own)")
        weights, actions, minibatches = (torch_generator(seeds.next()) for _ in range(3))
        self.name, self.upomdp, self.config = name, upomdp, config
        spaces, agents = (upomdp.agent_observation_space, upomdp.agent_action_space), upomdp.num_agents
        self.student = None if scripted else Student(*spaces, config, weights, upomdp.observation_scale, agents)
        self.worker = CompiledWorker(self.student, upomdp, config.num_steps, actions, on_episode_end)
        self.ppo = None if self.student is None else PPO(self.student, config, minibatches)
        self.values = EpisodeValues(upomdp.num_envs, agents=scored_agents(upomdp))
        shape = tuple(self.rollout.reward.shape[1:])
        self.rewards = RewardScale(shape, config.gamma) if config.norm_reward and not scripted else None
        self.recent = np.zeros(0)  # returns of its latest episodes, at most RECENT
        self.learn_seconds = 0.0
        self.reference_policy: AnnealedKL | None = None  # the initial policy, if the student is regularized toward it

    def start_from(self, student: Mapping[str, Any], kl_coef: float, kl_env_steps: int) -> None:
        """Start from this student, a `state_dict` with its normalizer; regularize toward it if `kl_coef` > 0.

        Raises RuntimeError for a student with other observations, actions or networks.
        """
        if self.student is None:
            return
        self.student.load_state_dict(student)
        self.reference_policy = AnnealedKL(copy.deepcopy(self.student), kl_coef, kl_env_steps)

    def to(self, device: torch.device) -> None:
        """Move the networks and the observations of rollouts to a device.

        The rest of a rollout, the simulator and all random streams stay on the host.
        """
        if self.student is not None and device.type != "cpu":
            self.student.to(device)
            self.worker.send = Upload(self.rollout.observation[0])
            self.rollout.observation = self.rollout.observation.to(device)

    @property
    def rollout(self) -> Rollout:
        """The last rollout."""
        return self.worker.rollout

    def start(self, records: np.ndarray) -> None:
        """Start an episode on the level of each record `[N]`; open episodes are dropped."""
        self.worker.start(records)
        self._forget_open()

    def _forget_open(self) -> None:
        """Discard the statistics of open episodes: all environments were reset."""
        self.values.reset()
        if self.rewards is not None:
            self.rewards.reset()

    def follow_negative_advantages(self) -> None:
        """Add maximized negative advantages, which a score needs, to the statistics of all future episodes."""
        self.values = EpisodeValues(self.upomdp.num_envs, True, scored_agents(self.upomdp))

    def compute_advantages(self) -> dict[str, np.ndarray]:
        """Compute advantages; return the critic's statistics of the E episodes that ended, `[E]` by name."""
        discounts, learned, scored = (self.config.gamma, self.config.gae_lambda), self.rollout, self.rollout
        if self.rewards is not None:
            learned, scored = self.rewards.normalize(self.rollout), self.rewards.with_raw_rewards(self.rollout)
        self.advantages = gae(learned, *discounts)  # [T, N]
        of_scores = self.advantages if scored is learned else gae(scored, *discounts)
        negative = negative_advantages(scored, *discounts) if self.values.negative else None
        return self.values.track(scored, of_scores, negative)

    def learn(
        self, env_steps: int, regularizer: KLRegularizer | None = None, rollout: Rollout | None = None
    ) -> dict[str, float]:
        """Learn from the last rollout, or from `rollout` instead; return metrics of episodes and losses.

        `env_steps` of all learners so far anneal the learning rate. `regularizer` defaults to that of `start_from`.
        """
        if regularizer is None and self.reference_policy is not None:
            regularizer = self.reference_policy.at(env_steps)
        began, losses = perf_counter(), dict[str, float]()
        if self.ppo is not None:
            advantages = self.advantages if rollout is None else None
            losses = self.ppo.learn(rollout or self.rollout, env_steps, advantages, regularizer)
        self.learn_seconds = perf_counter() - began
        ended = self.worker.pop_episodes()
        self.recent = np.append(self.recent, ended.returns)[-RECENT:]
        episodes = episode_metrics(self.name, ended, self.recent)
        episodes[f"open/{self.name}"] = float(self.worker.lengths.max())
        if self.student is not None:  # a rollout has no actions of a scripted policy
            losses |= action_shares(self.rollout, self.upomdp)
        losses |= {} if self.rewards is None else {"reward_scale": self.rewards.scale}
        return episodes | {f"{self.name}/{loss}": value for loss, value in losses.items()}

    def pop_seconds(self) -> dict[str, float]:
        """Return the seconds since the last call, by activity."""
        seconds, self.learn_seconds = self.worker.pop_seconds() | {"learn": self.learn_seconds}, 0.0
        return seconds

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Return the whole state; without `episodes`, leave out the state of the environments."""
        return {
            "agents": self.upomdp.num_agents,
            "worker": self.worker.state_dict(episodes),
            "ppo": None if self.ppo is None else self.ppo.state_dict(),
            "values": self.values.state_dict(),
            "recent": self.recent.copy(),
            **({} if self.rewards is None else {"rewards": self.rewards.state_dict()}),
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`. Raises `ValueError` for another number of agents."""
        self.check_agents(state)
        self.worker.load_state_dict(state["worker"])
        if self.ppo is not None:
            self.ppo.load_state_dict(state["ppo"])
        self.values.load_state_dict(state["values"])
        if self.rewards is not None:
            self.rewards.load_state_dict(state["rewards"])
        self.recent = np.array(state["recent"], np.float64)
        if state["worker"]["upomdp"] is None:  # the episodes of this state were restarted
            self._forget_open()

    def check_agents(self, state: dict[str, Any]) -> None:
        """Raise `ValueError` if a state has another number of agents."""
        saved, agents = state.get("agents", 1), self.upomdp.num_agents
        if saved != agents:
            raise ValueError(f"the checkpoint holds a student of {counted(saved)}, the environments have {agents}")


def counted(agents: int) -> str:
    return "one agent" if agents == 1 else f"{agents} agents"


def action_shares(rollout: Rollout, upomdp: UPOMDP) -> dict[str, float]:
    """Return the share of each action of each agent of a team; empty for one agent and for continuous actions."""
    space, agents = upomdp.agent_action_space, upomdp.num_agents
    if agents == 1 or not isinstance(space, Discrete):
        return {}
    counts = np.stack([np.bincount(taken, minlength=int(space.n)) for taken in rollout.action.flatten(0, 1).T.numpy()])
    shares = counts / rollout.terminated.numel()  # [A, actions]
    return {
        f"agent_{agent}/action_{space.start + action}": float(share)
        for agent, row in enumerate(shares)
        for action, share in enumerate(row)
    }


def episode_metrics(name: str, episodes: Episodes, recent: np.ndarray) -> dict[str, float]:
    """Return mean return, mean length and number of a student's episodes, and the mean of its `recent` returns.

    Means are nan without an episode.
    """
    count = len(episodes.returns)
    return {
        f"return/{name}": float(episodes.returns.mean()) if count else float("nan"),
        f"return_{RECENT}/{name}": float(recent.mean()) if len(recent) else float("nan"),
        f"length/{name}": float(episodes.lengths.mean()) if count else float("nan"),
        f"episodes/{name}": float(count),
    }
