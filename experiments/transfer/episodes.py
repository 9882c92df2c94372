"""Episodes of a program under given actions or a policy, in our simulator or in GRF.

Read next: `transfer.replaying`, which plays the same episodes in both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.envs.football.constants import DURATION, GOAL, OUT_OF_PLAY, POSSESSION, RUNNING, STEP
from regista.envs.football.vector_env import FootballVectorEnv

if TYPE_CHECKING:
    from regista.experiments.pictures.side_by_side import SideBySide
    from ued.core.painter import ScenePainter

Choose = Callable[[Any, int], np.ndarray]  # observations [N, ...] and the number of the step -> actions [N(, A)]
ENGINES = ("ours", "grf")
NO_ACTION = -1
WORDS = {RUNNING: "running", OUT_OF_PLAY: "out of play", POSSESSION: "possession", DURATION: "time"}
ENDINGS = ("scored", "conceded", *(WORDS[end] for end in (OUT_OF_PLAY, POSSESSION, DURATION)), "program", "running")


@dataclass(frozen=True)
class Episodes:
    """E episodes of P players, at most T steps; row 0 is the start, and ended episodes repeat their last state.

    Positions are in m, y upwards. `observations` are the inputs of the policy; empty unless saved. For several agents,
    actions and observations have an agent axis, `[E, T, A, ...]`.
    """

    ball: np.ndarray  # [E, T + 1, 3]
    places: np.ndarray  # [E, T + 1, P, 2]
    owner: np.ndarray  # [E, T + 1], index of the player as in `state.MATCH_FIELDS`, -1 for none
    actions: np.ndarray  # [E, T], NO_ACTION after the end
    observations: np.ndarray  # [E, T, F]
    lengths: np.ndarray  # [E], steps
    ended: np.ndarray  # [E], codes as `constants.RUNNING`
    score: np.ndarray  # [E, 2]
    returns: np.ndarray  # [E]

    def __len__(self) -> int:
        return len(self.lengths)

    @property
    def scored(self) -> np.ndarray:
        """Whether the left team scored, `[E]`."""
        return self.score[:, 0] > 0

    def endings(self) -> np.ndarray:
        """Return the ending of each episode, `[E]` of ENDINGS."""
        words = np.array([WORDS.get(int(end), "program") for end in self.ended], dtype=object)
        goals = np.where(self.scored, "scored", "conceded")
        return np.where(self.ended == GOAL, goals, words)

    def points(self) -> np.ndarray:
        """Return the positions of all players, then the ball, as painters order them: `[E, T + 1, P + 1, 2]` m."""
        return np.concatenate([self.places, self.ball[:, :, None, :2]], axis=2)


def side_by_side(name: str, painter: ScenePainter, ours: Episodes, grf: Episodes, row: int) -> SideBySide:
    """Return episode `row` in both engines, up to its end in each, for a recording."""
    from regista.experiments.pictures.side_by_side import SideBySide

    both = ours, grf
    points = [episodes.points()[row, : episodes.lengths[row] + 1] for episodes in both]
    ends = [str(episodes.endings()[row]) for episodes in both]
    actions = max(both, key=lambda episodes: episodes.lengths[row]).actions[row]
    actions = actions.reshape(len(actions), -1)[:, 0]  # the first agent's
    played = actions[actions != NO_ACTION]
    return SideBySide(name, painter, ENGINES, (points[0], points[1]), played, (ends[0], ends[1]))


def play(
    env: FootballVectorEnv,
    choose: Choose,
    levels: np.ndarray,
    steps: int | None = None,
    observed: bool = False,
    go_on: Callable[[int], bool] | None = None,
) -> Episodes:
    """Play one episode on each level `[E]`, for at most this many steps; `observed` saves observations.

    `env` is reset. `go_on` is called after each batch with its number of episodes; if it returns False, the remaining
    levels are not played.
    """
    parts = []
    for at in range(0, len(levels), env.num_envs):
        parts.append(_play_batch(env, choose, levels[at : at + env.num_envs], steps, observed))
        if go_on is not None and not go_on(len(parts[-1])):
            break
    return join(parts)


def play_keys(env: FootballVectorEnv, keys: np.ndarray, levels: np.ndarray) -> Episodes:
    """Play the given actions on each level `[E]`: the same ones `[T]` on all levels, or `[E, T]` by episode.

    For several agents, actions are `[E, T, A]`.
    """
    keys = np.broadcast_to(keys, (len(levels), len(keys))) if keys.ndim == 1 else keys
    parts = []
    for at in range(0, len(levels), env.num_envs):
        own = np.resize(keys[at : at + env.num_envs], (env.num_envs, *keys.shape[1:]))
        parts.append(
            play(env, lambda _, step, own=own: own[:, step], levels[at : at + env.num_envs], own.shape[1])  # type: ignore[misc]
        )
    return join(parts)


def join(parts: list[Episodes]) -> Episodes:
    """Concatenate episodes; shorter ones repeat their last state."""
    longest = max(part.actions.shape[1] for part in parts)
    joined = {}
    for field in fields(Episodes):
        arrays = [getattr(part, field.name) for part in parts]
        if field.name in ("actions", "observations"):
            arrays = [_longer(array, longest, NO_ACTION if field.name == "actions" else np.nan) for array in arrays]
        elif arrays[0].ndim > 1 and field.name != "score":
            arrays = [np.concatenate([a, np.repeat(a[:, -1:], longest + 1 - a.shape[1], 1)], 1) for a in arrays]
        joined[field.name] = np.concatenate(arrays)
    return Episodes(**joined)


def _longer(array: np.ndarray, steps: int, filling: float) -> np.ndarray:
    """Pad an array `[E, T, ...]` to this many steps."""
    shape = (len(array), steps - array.shape[1], *array.shape[2:])
    return np.concatenate([array, np.full(shape, filling, array.dtype)], 1)


def _play_batch(
    env: FootballVectorEnv, choose: Choose, levels: np.ndarray, steps: int | None, observed: bool
) -> Episodes:
    """Play at most N episodes in parallel; environments without a running episode idle."""
    count, n = len(levels), env.num_envs
    observation, _ = env.reset_to_levels(np.resize(levels, n))
    running = np.arange(n) < count
    returns, ended, lengths = np.zeros(n), np.full(n, RUNNING), np.zeros(n, np.int64)
    frames = [_frame(env.matches)]
    actions: list[np.ndarray] = []
    seen: list[np.ndarray] = []
    while running.any() and (steps is None or len(actions) < steps):
        env.idle[:] = ~running
        chosen = choose(observation, len(actions))
        actions.append(_held(running, chosen, NO_ACTION))
        if observed:
            seen.append(_held(running, observation, np.nan).astype(np.float32))
        observation, rewards, terminated, truncated, info = env.advance(chosen)
        over = (terminated | truncated) & running
        now = _frame(env.matches)
        frames.append([_held(running, new, old) for new, old in zip(now, frames[-1], strict=True)])
        returns[running] += rewards[running]
        lengths += running
        ended[over] = info["ended"][over]
        running &= ~over
    env.idle[:] = False
    ball, places, owner, score = (np.stack(frame, 1)[:count] for frame in zip(*frames, strict=True))
    played = np.stack(actions, 1)[:count]
    watched = np.stack(seen, 1)[:count] if observed else np.zeros((*played.shape, 0), np.float32)
    places = places[:, :, : env.num_players]
    return Episodes(ball, places, owner, played, watched, lengths[:count], ended[:count], score[:, -1], returns[:count])


def _held(running: np.ndarray, new: np.ndarray, old: np.ndarray | float) -> np.ndarray:
    return np.where(running.reshape(-1, *(1,) * (new.ndim - 1)), new, old)


def _frame(matches: np.ndarray) -> list[np.ndarray]:
    """Return ball `[N, 3]`, positions `[N, 22, 2]`, owner `[N]` and score `[N, 2]` of matches."""
    ball, players = matches["ball"], matches["players"]
    return [
        np.stack([ball[axis] for axis in "xyz"], -1),
        np.stack([players[axis] for axis in "xy"], -1),
        matches["reported_owner"].copy(),
        matches["score"].copy(),
    ]


def seconds(step: int) -> str:
    """Return the time of a step as text."""
    return f"{step * STEP:g} s"
