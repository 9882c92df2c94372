"""Evaluate a student on levels: a fixed list of whole episodes, all played to the end.

Counting the episodes that end within a number of steps would overcount short episodes. So the list of episodes is fixed
first, and each environment takes the next one when its episode ends. Read next: `statistics`, for confidence intervals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from ued.core.baselines import stage_of, within
from ued.core.level_space import SEEDS
from ued.core.seeding import SeedStream, torch_generator
from ued.core.upomdp import PREFETCH, UPOMDP, successes
from ued.learning.student import Player, Student

OnEnd = Callable[[int], None]  # called with the number of episodes that have just ended
LONGEST_EPISODE = 1_000_000  # steps, after which an evaluation fails


@dataclass(frozen=True)
class Evaluation:
    """E whole episodes of one student.

    Attributes:
        returns: `[E]` undiscounted.
        success: `[E]` 1 or 0; see `upomdp.successes`.
        lengths: `[E]` steps.
        level: `[E]` index into `levels`.
        levels: `[L]` records of the given or sampled levels.
        env_steps: steps of these episodes.
    """

    returns: np.ndarray
    success: np.ndarray
    lengths: np.ndarray
    level: np.ndarray
    levels: np.ndarray
    env_steps: int


def evaluate(
    student: Student,
    upomdp: UPOMDP,
    episodes: int,
    seed: int,
    levels: np.ndarray | None = None,
    greedy: bool = False,
) -> Evaluation:
    """Play `episodes` whole episodes and return their results.

    With `levels` `[L]`, episode e plays level e mod L: the same layout each time, with new luck. Without `levels`,
    every episode plays a random level. Actions are sampled from the policy, or are its most likely ones if `greedy`.
    The environments are reset: if a training run uses them, pass a copy (`upomdp.copy()`).

    Raises:
        ValueError: fewer than one episode or no level.
        RuntimeError: an episode that never ends.
    """
    return Schedule(upomdp, episodes, seed, levels).play(student, greedy)


class Schedule:
    """The episodes of an evaluation, drawn before the first is played; see `evaluate` for arguments and errors.

    Attributes:
        levels: `[L]` records of the levels.
        index: `[E]` index of the level that each episode plays.
        visits: `[E]` visit number of that level, which determines the episode's luck.
    """

    def __init__(self, upomdp: UPOMDP, episodes: int, seed: int, levels: np.ndarray | None = None) -> None:
        if episodes < 1:
            raise ValueError(f"episodes must be at least 1, got {episodes}")
        if levels is not None and not len(levels):
            raise ValueError("levels must hold at least one level, got none")
        seeds = SeedStream(seed)
        upomdp.level_sampler = None
        upomdp.np_random = np.random.default_rng(seeds.next())
        self.upomdp = upomdp
        self.levels = upomdp.sample_levels(episodes) if levels is None else levels
        self.index = np.arange(episodes) % len(self.levels)
        self.visits = seeds.next() % SEEDS + np.arange(episodes) // len(self.levels)  # luck that depends on the seed
        self.action_seed = seeds.next()

    def play(self, student: Student, greedy: bool = False, on_end: OnEnd | None = None) -> Evaluation:
        """Play all episodes; `on_end` is called with the number of episodes that have just ended."""
        stage = stage_of(student, self.upomdp)
        player = Player(within(student, stage), torch_generator(self.action_seed), greedy)
        episodes = _Episodes(stage, self.levels[self.index], self.visits, on_end)
        while episodes.left:
            player.begin(episodes.step(player(episodes.observation)))
        if stage is not self.upomdp:
            stage.close()
        return self._result(episodes)

    def _result(self, played: _Episodes) -> Evaluation:
        steps = int(played.lengths.sum())
        return Evaluation(played.returns, played.success, played.lengths, self.index, self.levels.copy(), steps)


def play_together(
    schedules: Sequence[Schedule], student: Student, greedy: bool = False, on_end: OnEnd | None = None
) -> list[Evaluation]:
    """Play several schedules side by side, with one forward pass for the environments of all of them.

    Each has its own random numbers, so that the results are those of `Schedule.play`, up to rounding in the network.
    `student` is a `Student`; the schedules have the same observations and number of environments.
    """
    played = [_Episodes(one.upomdp, one.levels[one.index], one.visits, on_end) for one in schedules]
    streams = [torch_generator(one.action_seed) for one in schedules]
    running = list(zip(played, streams, strict=True))
    memory = student.empty_memory(sum(one.upomdp.num_envs for one in schedules))  # [K N, memory_width]
    while running:
        observation = np.concatenate([one.observation for one, _ in running])
        actions = student.play(observation, [stream for _, stream in running], greedy, memory)
        ends = [one.step(part) for (one, _), part in zip(running, np.split(actions, len(running)), strict=True)]
        memory[torch.as_tensor(np.concatenate(ends))] = 0.0
        left = [one.left for one, _ in running]
        if not all(left):
            memory = memory[torch.as_tensor(np.repeat(left, len(ends[0])))]
            running = [pair for pair in running if pair[0].left]
    return [schedule._result(one) for schedule, one in zip(schedules, played, strict=True)]


class _Episodes:
    """One episode on each level of `playlist` `[E]`, played in the N environments of `upomdp`.

    `visits` `[E]` are the visit numbers of the levels.

    Attributes:
        observation: `[N, ...]` the current observations.
        returns, success, lengths: `[E]` each, of the episodes that have ended.
        left: whether an episode of the list has not ended.
    """

    def __init__(self, upomdp: UPOMDP, playlist: np.ndarray, visits: np.ndarray, on_end: OnEnd | None) -> None:
        self.upomdp, self.playlist, self.visits, self.on_end = upomdp, playlist, visits, on_end
        count = len(playlist)
        self.returns, self.success, self.lengths = np.zeros(count), np.zeros(count), np.zeros(count, np.int64)
        self.episode = np.arange(upomdp.num_envs)  # [N] index of each environment's episode; E or more: not in the list
        self.next_episode = upomdp.num_envs
        upomdp.idle[:] = self.episode >= count
        self.announced = _announce(upomdp, playlist, self.next_episode)
        first = self.episode % count
        self.observation, _ = upomdp.reset_to_levels(playlist[first], None, visits[first])
        self.left = True

    def step(self, actions: np.ndarray) -> np.ndarray:
        """Play one step; return where an episode of the list has ended, bool `[N]`."""
        upomdp, episode = self.upomdp, self.episode
        self.observation, reward, terminated, truncated, info = upomdp.advance(actions)
        listed = episode < len(self.playlist)  # [N]
        self.returns[episode[listed]] += reward[listed]
        self.lengths[episode[listed]] += 1
        _check_lengths(self.lengths[episode[listed]])
        ends = (terminated | truncated) & listed  # [N]
        if ends.any():
            self.success[episode[ends]] = successes(info, np.flatnonzero(ends), self.returns[episode[ends]])
            self._begin_next(ends)
        return ends

    def _begin_next(self, ends: np.ndarray) -> None:
        """Begin the next episodes of the list where episodes have ended."""
        upomdp, episode, num_ends = self.upomdp, self.episode, int(ends.sum())
        episode[ends] = np.arange(self.next_episode, self.next_episode + num_ends)
        self.next_episode += num_ends
        if self.on_end is not None:
            self.on_end(num_ends)
        starts = ends & (episode < len(self.playlist))  # [N]
        upomdp.idle |= ends & ~starts  # environments without a further episode
        if starts.any():
            now = episode[starts]
            if now[-1] >= self.announced:
                self.announced = _announce(upomdp, self.playlist, self.next_episode)
            self.observation, _ = upomdp.reset_to_levels(self.playlist[now], starts, self.visits[now])
        self.left = bool((episode < len(self.playlist)).any())
        if not self.left:
            upomdp.idle[:] = False
            _announce(upomdp, self.playlist, len(self.playlist))


def _check_lengths(lengths: np.ndarray) -> None:
    if lengths.max() >= LONGEST_EPISODE:
        raise RuntimeError(f"an episode did not end within {LONGEST_EPISODE} steps; evaluation needs episodes that end")


def _announce(upomdp: UPOMDP, playlist: np.ndarray, first: int) -> int:
    """Let the environments prefetch the next levels, starting at index `first`; return the index after the last one."""
    coming = playlist[first : first + PREFETCH]
    upomdp.prefetch(coming)
    return first + len(coming)
