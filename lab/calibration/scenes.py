"""Play scenes drawn with a seed in Google Research Football (GRF) or in our simulator, and record them.

A scene is a Scenic program with uniformly drawn random values, and actions drawn for every episode. `record` keeps the
data of `experiments/transfer/episodes.py`, and the velocities. Read next: `shots_at_keeper.py`, which draws scenes.
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np

from lab.grf.differential import OURS
from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.transfer.episodes import Episodes, play
from ued.core.level_space import SEEDS, level_dtype

BATCH = 16  # episodes in parallel
HEAD = """param game_duration = {steps}
param offsides = False
param right_team_difficulty = {difficulty}
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = False
"""


@dataclass(frozen=True)
class Recording:
    """E episodes of P players over T steps: row t is the state before step t, in m and m/s, y upwards."""

    ball: np.ndarray  # [E, T, 6], position and velocity
    spin: np.ndarray  # [E, T, 2], m/s
    players: np.ndarray  # [E, T, P, 4], position and velocity
    facing: np.ndarray  # [E, T, P, 2]
    owner: np.ndarray  # [E, T], -1 none
    keys: np.ndarray  # [E, T]
    lengths: np.ndarray  # [E]
    scored: np.ndarray  # [E], by the left team

    def __len__(self) -> int:
        return len(self.lengths)


def record(body: str, keys: np.ndarray, engine: str, seed: int, difficulty: float = 0.6) -> Recording:
    """Play drawn scenes of a program, one episode for each row of `keys` `[E, T]`, the actions of the active player.

    `engine` is "grf" or "regista". Raises `GrfError` if GRF is not installed.
    """
    rng = np.random.default_rng(seed)
    count, steps = keys.shape
    head = HEAD.format(steps=steps + 20, difficulty=difficulty)
    config = replace(OURS, engine=engine, grf_workers=1)
    with closing(FootballVectorEnv(head + body, min(BATCH, count), config=config)) as env:
        levels = np.zeros(count, level_dtype(env.theta_dim))
        levels["seed"] = rng.integers(0, SEEDS, count)
        levels["theta"] = rng.uniform(-1.0, 1.0, levels["theta"].shape)
        parts = [_play(env, keys[at : at + BATCH], levels[at : at + BATCH]) for at in range(0, count, BATCH)]
    return Recording(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _play(env: FootballVectorEnv, keys: np.ndarray, levels: np.ndarray) -> tuple[np.ndarray, ...]:
    """Play one batch `[E, T]`; return the fields of a `Recording`."""
    seen: list[tuple[np.ndarray, ...]] = []
    padded = np.resize(keys, (env.num_envs, keys.shape[1]))

    def choose(_: object, step: int) -> np.ndarray:
        seen.append(_snapshot(env.matches, env.num_players))
        return padded[:, step]

    episodes: Episodes = play(env, choose, levels, keys.shape[1])
    missing = keys.shape[1] - len(seen)
    columns = [np.stack([*column, *[column[-1]] * missing], 1)[: len(keys)] for column in zip(*seen, strict=True)]
    return (*columns, keys, episodes.lengths, episodes.scored)


def _snapshot(matches: np.ndarray, num_players: int) -> tuple[np.ndarray, ...]:
    ball, players = matches["ball"], matches["players"][:, :num_players]
    return (
        np.stack([ball[name] for name in ("x", "y", "z", "vx", "vy", "vz")], -1),
        np.stack([ball[name] for name in ("spin_x", "spin_y")], -1),
        np.stack([players[name] for name in ("x", "y", "vx", "vy")], -1),
        np.stack([players[name] for name in ("facing_x", "facing_y")], -1),
        matches["reported_owner"].copy(),
    )


def kick_time(recording: Recording, episode: int, step: int) -> float:
    """Return the flight time in s of the ball when it is first seen off the foot, before this step.

    The kick is the time at which the ball's path, traced back along its velocity, is nearest to its previous path.
    """
    before, after = recording.ball[episode, step - 1], recording.ball[episode, step]
    change = after[3:5] - before[3:5]
    along = float(change @ (after[:2] - before[:2] - 0.1 * before[3:5]))
    return float(np.clip(along / (float(change @ change) + 1e-9), 0.0, 0.1))
