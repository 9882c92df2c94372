"""Evaluate a student on levels: a fixed list of whole episodes, all played to the end.

Counting the episodes that end within a number of steps would overcount short episodes. So the list of episodes is fixed
first, and each environment takes the next one when its episode ends. Read next: `statistics`, for confidence intervals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

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
        playlist = self.levels[self.index]
        returns, success, lengths = _play(player, stage, playlist, self.visits, on_end)
        if stage is not self.upomdp:
            stage.close()
        return Evaluation(returns, success, lengths, self.index, self.levels.copy(), int(lengths.sum()))


def _play(
    player: Player, upomdp: UPOMDP, playlist: np.ndarray, visits: np.ndarray, on_end: OnEnd | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Play one episode on each level of `playlist` `[E]`; return returns, success and lengths, `[E]` each.

    `visits` `[E]` are the visit numbers of the levels.
    """
    episodes, num_envs = len(playlist), upomdp.num_envs
    returns, success, lengths = np.zeros(episodes), np.zeros(episodes), np.zeros(episodes, np.int64)
    episode = np.arange(num_envs)  # [N] the index of each environment's episode; E or more: not in the list
    next_episode = num_envs
    upomdp.idle[:] = episode >= episodes
    announced = _announce(upomdp, playlist, next_episode)
    observation, _ = upomdp.reset_to_levels(playlist[episode % episodes], None, visits[episode % episodes])
    while (episode < episodes).any():
        observation, reward, terminated, truncated, info = upomdp.advance(player(observation))
        listed = episode < episodes  # [N]
        returns[episode[listed]] += reward[listed]
        lengths[episode[listed]] += 1
        _check_lengths(lengths[episode[listed]])
        ends = (terminated | truncated) & listed  # [N]
        num_ends = int(ends.sum())
        if num_ends:
            player.begin(ends)
            success[episode[ends]] = successes(info, np.flatnonzero(ends), returns[episode[ends]])
            episode[ends] = np.arange(next_episode, next_episode + num_ends)
            next_episode += num_ends
            if on_end is not None:
                on_end(num_ends)
            starts = ends & (episode < episodes)  # [N]
            upomdp.idle |= ends & ~starts  # environments without a further episode
            if starts.any():
                now = episode[starts]
                if now[-1] >= announced:
                    announced = _announce(upomdp, playlist, next_episode)
                observation, _ = upomdp.reset_to_levels(playlist[now], starts, visits[now])
    upomdp.idle[:] = False
    _announce(upomdp, playlist, episodes)
    return returns, success, lengths


def _check_lengths(lengths: np.ndarray) -> None:
    if lengths.max() >= LONGEST_EPISODE:
        raise RuntimeError(f"an episode did not end within {LONGEST_EPISODE} steps; evaluation needs episodes that end")


def _announce(upomdp: UPOMDP, playlist: np.ndarray, first: int) -> int:
    """Let the environments prefetch the next levels, starting at index `first`; return the index after the last one."""
    coming = playlist[first : first + PREFETCH]
    upomdp.prefetch(coming)
    return first + len(coming)
