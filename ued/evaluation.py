"""Evaluate a student on levels: a fixed list of whole episodes, all played to the end.

Counting the episodes that end within some number of steps would count short ones too often. Here the episodes to be
played are written down first, and each environment takes the next one when it is through. Read next: `statistics`, for
what the numbers are worth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from ued.learning.student import Student
from ued.seeding import split_seed, torch_stream
from ued.upomdp import UPOMDP

LONGEST_EPISODE = 1_000_000  # steps; an episode that has not ended by then never will


@dataclass(frozen=True)
class Evaluation:
    """E whole episodes of one student.

    Attributes:
        returns: `[E]` undiscounted.
        lengths: `[E]` steps.
        level: `[E]` index into `levels`.
        levels: `[L]` records of the levels that were asked for, or drawn.
        env_steps: steps simulated, those of environments waiting for the last episode included.
    """

    returns: np.ndarray
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
    """Play `episodes` whole episodes and give their returns.

    With `levels` `[L]`, episode e plays level e mod L, each time with a new seed; without, every episode plays a level
    of its own, drawn at random. Actions are drawn from the policy, or its most likely ones if `greedy`. The
    environments are reset, so they must not be those of a running training (use `upomdp.copy()`).

    Raises `ValueError` for fewer than one episode or no level, `RuntimeError` for an episode that never ends.
    """
    if episodes < 1:
        raise ValueError(f"episodes must be at least 1, got {episodes}")
    if levels is not None and not len(levels):
        raise ValueError("levels must hold at least one level, got none")
    stream, actions = split_seed(seed, 2)
    upomdp.next_levels = None
    upomdp.reset(seed=stream)
    asked = upomdp.sample_levels(episodes) if levels is None else levels
    index = np.arange(episodes) % len(asked)
    tasks = upomdp.make_levels(asked["theta"][index])  # with seeds of their own
    tasks["program"] = asked["program"][index]
    returns, lengths, env_steps = _play(student, upomdp, tasks, torch_stream(actions), greedy)
    return Evaluation(returns, lengths, index, asked.copy(), env_steps)


def _play(
    student: Student, upomdp: UPOMDP, tasks: np.ndarray, generator: torch.Generator, greedy: bool
) -> tuple[np.ndarray, np.ndarray, int]:
    """Play each of these levels `[E]` once; give returns `[E]`, lengths `[E]` and the steps it took."""
    episodes, num_envs = len(tasks), upomdp.num_envs
    returns, lengths = np.zeros(episodes), np.zeros(episodes, np.int64)
    task = np.arange(num_envs)  # which episode each environment plays; beyond the last: none that counts
    following = num_envs
    observation, _ = upomdp.reset_to_levels(tasks[task % episodes])
    steps = 0
    while (task < episodes).any():
        observation, reward, terminated, truncated, _ = upomdp.step(student.play(observation, generator, greedy))
        steps += 1
        counts = task < episodes
        returns[task[counts]] += reward[counts]
        lengths[task[counts]] += 1
        if lengths[task[counts]].max() >= LONGEST_EPISODE:
            raise RuntimeError(
                f"an episode did not end within {LONGEST_EPISODE} steps; evaluation needs episodes that end"
            )
        ended = (terminated | truncated) & counts
        free = int(ended.sum())
        if free:
            task[ended] = np.arange(following, following + free)
            following += free
            renewed = ended & (task < episodes)
            if renewed.any():
                observation, _ = upomdp.reset_to_levels(tasks[task[renewed]], renewed)
    return returns, lengths, steps * num_envs
