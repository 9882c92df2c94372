"""A learner: a student with all that plays and teaches it.

Read next: `methods.method`, which lets one or more of them play the same levels.
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
from ued.learning.kl import FadingKL, KLRegularizer
from ued.learning.ppo import PPO
from ued.learning.rollout import Rollout, gae
from ued.learning.student import Student
from ued.learning.upload import Upload
from ued.learning.value_stats import EpisodeValues
from ued.learning.worker import Episodes, OnEpisodeEnd, RolloutWorker

RECENT = 100  # episodes of a rolling return


class Learner:
    """A student, the worker that plays it, and PPO, which improves it.

    Args:
        name: before the name of each of its metrics.
        upomdp: N environments of its own.
        config: of the student and of PPO.
        seeds: of its weights, its actions, and the shuffling of minibatches, in this order.
        on_episode_end: decides which level an environment plays next; see `RolloutWorker`.
        scripted: the environments play the learner's part themselves: there is no student, and nothing is learned.

    Raises `ValueError` for one critic of opponents.
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
        if upomdp.paid_apart and config.critic == "central":
            raise ValueError("opponents are not worth the same: they need critic = own")
        weights, actions, minibatches = (torch_generator(seeds.next()) for _ in range(3))
        self.name, self.upomdp, self.config = name, upomdp, config
        spaces, agents = (upomdp.agent_observation_space, upomdp.agent_action_space), upomdp.num_agents
        self.student = None if scripted else Student(*spaces, config, weights, upomdp.observation_unit, agents)
        self.worker = RolloutWorker(self.student, upomdp, config.num_steps, actions, on_episode_end)
        self.ppo = None if self.student is None else PPO(self.student, config, minibatches)
        self.values = EpisodeValues(upomdp.num_envs)
        self.recent = np.zeros(0)  # returns of its last episodes, RECENT at most
        self.learn_seconds = 0.0
        self.origin: FadingKL | None = None  # what it began with, if it is to stay close to that at first

    def start_from(self, student: Mapping[str, Any], kl_coef: float, kl_env_steps: int) -> None:
        """Begin with this student, a `state_dict`, its normaliser included; stay close to it at first if told to.

        Raises RuntimeError for one of other observations, actions or networks.
        """
        if self.student is None:
            return
        self.student.load_state_dict(student)
        self.origin = FadingKL(copy.deepcopy(self.student), kl_coef, kl_env_steps)

    def to(self, device: torch.device) -> None:
        """Move the networks to a device, and what they see; all else of a rollout, the simulator and all random streams
        stay on the host.
        """
        if self.student is not None and device.type != "cpu":
            self.student.to(device)
            self.worker.send = Upload(self.rollout.observation[0])
            self.rollout.observation = self.rollout.observation.to(device)

    @property
    def rollout(self) -> Rollout:
        """What it experienced last."""
        return self.worker.rollout

    def start(self, records: np.ndarray) -> None:
        """Begin an episode on the level of each of these records `[N]`; open episodes are lost."""
        self.worker.start(records)
        self.values.reset()

    def compute_advantages(self) -> dict[str, np.ndarray]:
        """Look back on the rollout; return what the critic thought in the episodes that ended in it, `[E]` by name."""
        self.advantages = gae(self.rollout, self.config.gamma, self.config.gae_lambda)  # [T, N]
        return self.values.track(self.rollout, self.advantages)

    def learn(
        self, env_steps: int, regularizer: KLRegularizer | None = None, rollout: Rollout | None = None
    ) -> dict[str, float]:
        """Learn from the last rollout, or from `rollout` in its place; return the metrics of episodes and losses.

        `env_steps` are those of all learners so far, for the annealing of the learning rate. Without a `regularizer` of
        the method's the student stays close to what it began with, if it is to.
        """
        if regularizer is None and self.origin is not None:
            regularizer = self.origin.at(env_steps)
        began, losses = perf_counter(), dict[str, float]()
        if self.ppo is not None:
            advantages = self.advantages if rollout is None else None
            losses = self.ppo.learn(rollout or self.rollout, env_steps, advantages, regularizer)
        self.learn_seconds = perf_counter() - began
        ended = self.worker.pop_episodes()
        self.recent = np.append(self.recent, ended.returns)[-RECENT:]
        episodes = episode_metrics(self.name, ended, self.recent)
        episodes[f"open/{self.name}"] = float(self.worker.lengths.max())
        losses |= action_shares(self.rollout, self.upomdp)
        return episodes | {f"{self.name}/{loss}": value for loss, value in losses.items()}

    def pop_seconds(self) -> dict[str, float]:
        """Return the seconds spent since the last call, by what they were spent on."""
        seconds, self.learn_seconds = self.worker.pop_seconds() | {"learn": self.learn_seconds}, 0.0
        return seconds

    def state_dict(self, episodes: bool = True) -> dict[str, Any]:
        """Return everything that changes; without `episodes`, all but the state of the environments."""
        return {
            "agents": self.upomdp.num_agents,
            "worker": self.worker.state_dict(episodes),
            "ppo": None if self.ppo is None else self.ppo.state_dict(),
            "values": self.values.state_dict(),
            "recent": self.recent.copy(),
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` returned. Raises `ValueError` if it is of another number of agents."""
        self.check_agents(state)
        self.worker.load_state_dict(state["worker"])
        if self.ppo is not None:
            self.ppo.load_state_dict(state["ppo"])
        self.values.load_state_dict(state["values"])
        self.recent = np.array(state["recent"], np.float64)
        if state["worker"]["upomdp"] is None:  # its episodes have begun anew
            self.values.reset()

    def check_agents(self, state: dict[str, Any]) -> None:
        """Raise `ValueError` if what `state_dict` returned is of another number of agents."""
        saved, agents = state.get("agents", 1), self.upomdp.num_agents
        if saved != agents:
            raise ValueError(f"the checkpoint holds a student of {counted(saved)}, the environments have {agents}")


def counted(agents: int) -> str:
    return "one agent" if agents == 1 else f"{agents} agents"


def action_shares(rollout: Rollout, upomdp: UPOMDP) -> dict[str, float]:
    """Return how often each agent of a team has taken each action; of one agent, or of real numbers, nothing."""
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

    Means of none are nan.
    """
    count = len(episodes.returns)
    return {
        f"return/{name}": float(episodes.returns.mean()) if count else float("nan"),
        f"return_{RECENT}/{name}": float(recent.mean()) if len(recent) else float("nan"),
        f"length/{name}": float(episodes.lengths.mean()) if count else float("nan"),
        f"episodes/{name}": float(count),
    }
