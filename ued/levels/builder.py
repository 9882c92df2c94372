"""The adversary that builds levels step by step (PAIRED, Dennis et al. 2020, section 5), trained by PPO.

    z, luck of each level; nothing is built yet
    for each of K steps
        action ~ policy(level so far, number of the step, z)        no reward
    the finished levels are played; the reward of the last step is their score

So the adversary is a student whose episodes are levels. As in DCD (`MultigridNetwork`), it observes the step number as
a one-hot vector. Two things differ from DCD. z is drawn once per level instead of at each step. The network is
feed-forward by default, since an action depends only on the level so far and the step.

Scores arrive later, in any order, and some never arrive. So a proposal stores the data of its update: z, luck, actions,
log-probabilities and values. Its observations, which are much larger, are recomputed when its score is available. Read
next: `core.families`, the definition of a level family; `levels.teacher`, which uses the adversary.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import torch
from gymnasium.spaces import Box, Discrete

from ued.config import AdversaryConfig, PPOConfig
from ued.core.families import LevelBuilder
from ued.core.level_space import SEEDS
from ued.core.resumable import Resumable
from ued.core.room import machine_bytes, size
from ued.learning.ppo import PPO
from ued.learning.rollout import Rollout
from ued.learning.student import Student
from ued.levels.adversary import RunningScale
from ued.levels.budget import BATCH


class Built(NamedTuple):
    """Proposals of the adversary with the data for learning.

    z `[n, Z]` float32: context; luck `[n]` int64: see `LevelBuilder`; action `[n, K]` int32; log_prob, value `[n, K]`
    float32: when proposed.
    """

    z: np.ndarray
    luck: np.ndarray
    action: np.ndarray
    log_prob: np.ndarray
    value: np.ndarray


class Builder(Resumable):
    """Builds levels and learns from their scores; see `Adversary` for an adversary that chooses them in one step.

    Args:
        builder: the steps in which levels are built.
        config: its network and learning, see `AdversaryConfig.steps`.
        generator: random generator of weights, samples and minibatches.

    Raises:
        ValueError: a builder without steps or actions, with observations that are not vectors, or with levels that need
            more memory than this machine has.
    """

    state_fields = ("ppo", "scale")

    def __init__(self, builder: LevelBuilder, config: AdversaryConfig, generator: torch.Generator) -> None:
        self.builder, self.config, self.generator = builder, config, generator
        self.steps, self.context_size = int(builder.steps), config.context_size
        self.size = _check(builder)
        settings = ppo_settings(config, self.steps)
        seen = Box(-np.inf, np.inf, (self.size + self.steps + self.context_size,), np.float32)
        student = Student(seen, Discrete(int(builder.actions)), settings, generator, np.ones(seen.shape))
        self.ppo = PPO(student, settings, generator)
        self.scale = RunningScale()

    @property
    def record_fields(self) -> list[tuple[Any, ...]]:
        """The fields of a level record that hold a proposal: the fields of `Built`."""
        each = (self.steps,)
        return [
            ("z", np.float32, (self.context_size,)),
            ("luck", np.int64),
            ("action", np.int32, each),
            ("log_prob", np.float32, each),
            ("value", np.float32, each),
        ]

    def read(self, records: np.ndarray) -> Built:
        """Return the proposals in these fields of level records `[n]`."""
        return Built(*(np.ascontiguousarray(records[name]) for name in Built._fields))

    def propose(self, count: int, context: np.ndarray | None = None) -> Built:
        """Build `count` levels, from random vectors or from this context `[count, context_size]`."""
        if context is None:
            context = torch.empty(count, self.context_size).normal_(generator=self.generator).numpy()
        luck = torch.randint(SEEDS, (count,), generator=self.generator).numpy()
        built = Built(
            np.asarray(context, np.float32),
            luck,
            np.zeros((count, self.steps), np.int32),
            *(np.zeros((count, self.steps), np.float32) for _ in range(2)),
        )
        memory = self.ppo.student.empty_memory(count)
        for step, seen in enumerate(self._observations(built)):
            drawn = self.ppo.student.act(torch.from_numpy(seen), self.generator, memory)
            for column, part in zip((built.action, built.log_prob, built.value), drawn, strict=True):
                column[:, step] = part.numpy()
        return built

    def theta(self, proposals: Built) -> np.ndarray:
        """Return the codes of the finished levels, float64 `[n, D]` in [-1, 1]."""
        levels = self.builder.begin(proposals.luck)
        for action in proposals.action.T:
            levels = self.builder.apply(levels, action.astype(np.int64))
        return np.array(self.builder.codes(levels), np.float64)

    def learn(self, proposals: Built, score: np.ndarray) -> dict[str, float]:
        """Update on the scores `[n]` of these proposals; return PPO's metrics.

        Scores are normalized by a running mean and standard deviation, so that `ent_coef` does not depend on their
        scale.
        """
        self.scale.track(score)
        return self.ppo.learn(self._rollout(proposals, self.scale(score)))

    def _observations(self, proposals: Built) -> Iterator[np.ndarray]:
        """Yield the observations `[n, size + K + Z]` before each step; the caller may set its actions in between."""
        levels = self.builder.begin(proposals.luck)
        for step in range(self.steps):
            seen = np.zeros((len(proposals.luck), self.size + self.steps + self.context_size), np.float32)
            seen[:, : self.size] = self.builder.observe(levels)
            seen[:, self.size + step] = 1.0
            seen[:, self.size + self.steps :] = proposals.z
            yield seen
            levels = self.builder.apply(levels, proposals.action[:, step].astype(np.int64))

    def _rollout(self, proposals: Built, reward: np.ndarray) -> Rollout:
        """Return proposals as K steps of n environments whose episodes end with the last step and its reward `[n]`."""
        shape = (self.steps, len(reward))
        action, log_prob, value = (torch.from_numpy(np.ascontiguousarray(part.T)) for part in proposals[2:])
        rewards, ended = torch.zeros(shape), torch.zeros(shape, dtype=torch.bool)
        rewards[-1], ended[-1] = torch.as_tensor(reward, dtype=torch.float32), True
        return Rollout(
            observation=torch.from_numpy(np.stack(list(self._observations(proposals)))),
            action=action.long(),
            log_prob=log_prob,
            value=value,
            reward=rewards,
            terminated=ended,
            truncated=torch.zeros_like(ended),
            final_value=torch.zeros(shape),
            train=torch.ones_like(ended),
            last_value=torch.zeros(shape[1]),
            memory=self.ppo.student.empty_memory(shape[1]),
        )

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`.

        Raises:
            ValueError: the state of another kind of adversary, or for other levels.
        """
        if "ppo" not in state:
            raise ValueError("the saved adversary chooses levels in one step (builder = direct), this one builds them")
        own, saved = (
            {name: list(weight.shape) for name, weight in weights.items()}
            for weights in (self.ppo.student.state_dict(), state["ppo"]["student"])
        )
        if own != saved:
            other = next(name for name in sorted(own.keys() | saved.keys()) if own.get(name) != saved.get(name))
            raise ValueError(
                f"the saved adversary has other observations, actions or layers: its {other} is {saved.get(other)}, "
                f"this one's {own.get(other)}"
            )
        super().load_state_dict(state)


def ppo_settings(config: AdversaryConfig, steps: int) -> PPOConfig:
    """Return the settings of PPO for levels of this many steps.

    Observations are already in about [-1, 1], so they are centered, but not divided by deviations below 1.
    """
    return PPOConfig(
        num_steps=steps,
        clip_coef=config.clip_coef,
        vf_coef=config.vf_coef,
        max_grad_norm=config.max_grad_norm,
        adam_eps=config.adam_eps,
        hidden_size=config.hidden_size,
        obs_std_floor=1.0,
        **vars(config.steps),
    )


def builder_setting(kind: str) -> str:
    """Return the setting of this builder in Python and on the command line."""
    return f"builder={kind!r} (--METHOD.adversary.builder {kind})"


def _check(builder: LevelBuilder) -> int:
    """Return the size of a builder's observations. Raises `ValueError` for an invalid builder."""
    name = type(builder).__name__
    if builder.steps < 1 or builder.actions < 1:
        raise ValueError(
            f"{name} must have at least one step and one action, got {builder.steps} steps of {builder.actions} actions"
        )
    shape = np.shape(builder.observe(builder.begin(np.zeros(2, np.int64))))
    if len(shape) != 2 or shape[0] != 2:
        raise ValueError(f"{name}.observe must return a vector per level, for 2 levels [2, F], got {list(shape)}")
    needed = 4 * BATCH * builder.steps * (shape[1] + builder.steps)
    if needed > machine_bytes():
        raise ValueError(
            f"a batch of {BATCH} levels of {builder.steps:_} steps, each observed as {shape[1]:_} numbers, needs "
            f"{size(needed)}, this machine has {size(machine_bytes())}; build smaller levels, or use "
            f"{builder_setting('direct')}"
        )
    return shape[1]
