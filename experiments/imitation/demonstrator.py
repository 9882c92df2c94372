"""Episodes for imitation: a program or a trained student plays one episode in each of N parallel matches.

Observations and actions stay in memory until an episode ends; images are packed as bits, since planes hold only 0 and
255. Read next: `imitation.demonstrations`, the folder of the episodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.envs.football.constants import NO_ACTION

if TYPE_CHECKING:
    from regista.envs.football.replay import Record
    from regista.envs.football.vector_env import FootballVectorEnv

Choose = Callable[[Any], np.ndarray]  # observations [N, ...] -> actions [N] or [N, A]


@dataclass(frozen=True)
class Episode:
    """One episode of T steps and A agents; a single agent has no axis A.

    Attributes:
        observations: `[T + 1, ...]`, the last one after the last step.
        actions: `[T]` or `[T, A]`, in [0, 19).
        mask: bool, shape of `actions`: whether the behavior matches one of the 19 actions; if not, the action is 0.
        rewards: `[T]`; `agent_rewards`: `[T, A]`.
        terminated: whether it ended by an event rather than the time limit.
    """

    observations: np.ndarray
    actions: np.ndarray
    mask: np.ndarray
    rewards: np.ndarray
    agent_rewards: np.ndarray
    terminated: bool


@dataclass(frozen=True)
class Part:
    """The N episodes of one part: levels, returns, success (0 or 1) and lengths `[N]`, and their record."""

    levels: np.ndarray
    returns: np.ndarray
    success: np.ndarray
    lengths: np.ndarray
    record: Record
    _steps: _Steps

    def episode(self, index: int) -> Episode:
        """Return one episode."""
        return self._steps.episode(index, int(self.lengths[index]))


def play_part(env: FootballVectorEnv, choose: Choose | None, levels: np.ndarray) -> Part:
    """Play one episode on each level `[N]`; without a policy the program acts (`env.scripted`)."""
    from regista.envs.football.replay import Record
    from ued.core.upomdp import successes

    observation, _ = env.reset_to_levels(levels)
    state, size = env.get_state(), env.num_envs
    steps = _Steps(env.num_agents, env.single_observation_space.dtype == np.uint8)
    running, lengths = np.ones(size, bool), np.zeros(size, np.int64)
    returns, success = np.zeros(size), np.zeros(size)
    shape = env.action_space.shape
    assert shape is not None
    no_actions = np.zeros(shape, np.int64)
    while running.any():
        env.idle[:] = ~running
        actions = no_actions if choose is None else choose(observation)
        seen = observation
        observation, rewards, terminated, truncated, info = env.advance(actions)
        over = (terminated | truncated) & running
        steps.add(seen, info, rewards, terminated)
        returns[running] += rewards[running]
        ended = np.flatnonzero(over)
        if len(ended):
            steps.end(ended, observation)
            success[ended] = successes(info, ended, returns[ended])
        lengths += running
        running &= ~over
    env.idle[:] = False
    done = np.array(steps.actions).reshape(len(steps.actions), *shape)
    done = done if env.scripted else np.maximum(done, 0)  # idle for matches that were not stepped
    program = env.program
    folder = program.mode.state.root
    file = "" if folder is None else str((folder / program.file).resolve())
    last = np.asarray(env.matches)
    record = Record(program.source, file, env.config, state, done, last, env.scripted, lengths)
    return Part(levels, returns, success, lengths, record, steps)


class _Steps:
    """Observations and actions of all matches, step by step."""

    def __init__(self, agents: int, planes: bool) -> None:
        self.actions: list[np.ndarray] = []  # [N, A], NO_ACTION if the behavior matches none of the 19 actions
        self._planes, self._agents = planes, agents
        self._seen: list[np.ndarray] = []
        self._rewards: list[np.ndarray] = []
        self._agent_rewards: list[np.ndarray] = []
        self._terminated: list[np.ndarray] = []
        self._last: dict[int, np.ndarray] = {}
        self._shape: tuple[int, ...] = ()

    def add(self, seen: np.ndarray, info: dict[str, Any], rewards: np.ndarray, terminated: np.ndarray) -> None:
        """Store a step."""
        self._shape = seen.shape[1:]
        self._seen.append(self._packed(seen))
        self.actions.append(info["agent_actions"])
        self._rewards.append(rewards)
        self._agent_rewards.append(info["agent_rewards"])
        self._terminated.append(terminated)

    def end(self, ended: np.ndarray, final: np.ndarray) -> None:
        """Store the final observations of episodes."""
        for index in ended:
            self._last[int(index)] = self._packed(final[index : index + 1])[0]

    def episode(self, index: int, length: int) -> Episode:
        """Return the episode of one match."""
        seen = np.stack([*(array[index] for array in self._seen[:length]), self._last[index]])
        actions = np.stack([array[index] for array in self.actions[:length]])
        actions = actions if self._agents > 1 else actions[:, 0]
        mask = actions != NO_ACTION
        return Episode(
            self._unpacked(seen),
            np.where(mask, actions, 0),
            mask,
            np.array([array[index] for array in self._rewards[:length]]),
            np.stack([array[index] for array in self._agent_rewards[:length]]),
            bool(self._terminated[length - 1][index]),
        )

    def _packed(self, seen: np.ndarray) -> np.ndarray:
        return np.packbits(seen.reshape(len(seen), -1) != 0, axis=1) if self._planes else seen

    def _unpacked(self, seen: np.ndarray) -> np.ndarray:
        if not self._planes:
            return seen
        size = int(np.prod(self._shape))
        return np.unpackbits(seen, axis=1, count=size).reshape(len(seen), *self._shape) * np.uint8(255)


def parts(env: FootballVectorEnv, choose: Callable[[int], Choose] | None, seed: int, first: int) -> Iterator[Part]:
    """Play parts in order, starting with number `first`; each has its own levels, seeds and generator.

    So part p does not depend on whether earlier parts were played in the same process.
    """
    number = first
    while True:
        env.reset(seed=part_seed(seed, number))
        levels = env.sample_levels(env.num_envs)
        yield play_part(env, None if choose is None else choose(part_seed(seed, number)), levels)
        number += 1


def part_seed(seed: int, number: int) -> int:
    """Return the seed of one part."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1, np.uint64)[0] >> 1)
