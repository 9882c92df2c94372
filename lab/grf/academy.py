"""Whole episodes: how often scripted policies and the built-in players score on jittered academy scenes.

Every player of a scene is up to JITTER m from the academy's position in x and in y; the ball moves with its carrier.
Both engines play the same drawn scenes. Read next: `grf.players`, whole matches.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from lab.grf.drawn_scenes import program_text
from lab.grf.figures import Panel, draw_panels
from lab.grf.policies import policy_named
from lab.grf.report import read_data
from lab.grf.rows import Row, by_distance
from lab.grf.scenes import SCENES
from regista.envs.football.config import FootballConfig
from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.run.config import TEST_ENVS
from regista.experiments.transfer.episodes import ENDINGS, Episodes, play
from ued.core.level_space import level_dtype

TITLE = "jittered academy scenes"
REQUIRED = 0.8  # share of the rows that should be within tolerance
TOLERANCE = 0.12
JITTER = 2.0  # m, maximum offset of each player in x and in y
DRAWN = 200  # scenes of each row, the same for all of its policies
EPISODES = 2 * DRAWN  # at effort 1, in our simulator
GRF_EPISODES = DRAWN
SEED = 40_000
OURS = FootballConfig("features", control="active")
BUILT_IN = "builtin_ai"  # the built-in AI also controls the agent's player
ROWS = (
    ("empty_goal_close", "always_shot"),
    ("empty_goal", "always_shot"),
    ("run_to_score", "run_right_nosprint_shot_0.80"),
    ("run_to_score_with_keeper", "builtin_ai"),
    ("run_to_score_with_keeper", "sprint_right_hold_only"),
    ("run_to_score_with_keeper", "sprint_right_shot_0.70"),
    ("pass_and_shoot_with_keeper", "builtin_ai"),
    ("pass_and_shoot_with_keeper", "run_to_goal_aimed_shot_0.75"),
    ("pass_and_shoot_with_keeper", "short_pass_bottom_then_aimed_shot_press1"),
    ("pass_and_shoot_with_keeper", "short_pass_nodir_then_shotcycle"),
    ("run_pass_and_shoot_with_keeper", "run_to_goal_aimed_shot_0.85"),
    ("run_pass_and_shoot_with_keeper", "short_pass_bottom_then_shotcycle"),
    ("3_vs_1_with_keeper", "builtin_ai"),
    ("3_vs_1_with_keeper", "aimed_shot_now_press1"),
    ("3_vs_1_with_keeper", "short_pass_bottom_right_run_0.80_aimed_shot"),
    ("3_vs_1_with_keeper", "short_pass_bottom_right_then_aimed_shot"),
    ("3_vs_1_with_keeper", "sprint_right_aimed_shot_0.75"),
    ("3_vs_1_with_keeper", "sprint_right_shot_0.75"),
)


def play_policy(scene: str, policy: str, count: int, config: FootballConfig = OURS) -> Episodes:
    """Play `count` episodes of a policy on a scene's drawn levels, in the engine of a configuration."""
    text = program_text(SCENES[scene], JITTER)
    with closing(FootballVectorEnv(text, min(count, TEST_ENVS[config.engine]), config=config)) as env:
        levels = drawn_levels(env, count)
        if policy == BUILT_IN:
            env.reset(seed=SEED)
            with closing(env.with_scripted_policy()) as script:
                return play(script, lambda _, step: np.zeros(env.num_envs, np.int64), levels)
        keys = policy_named(policy)

        def choose(observation: Any, step: int) -> np.ndarray:
            if step == 0:
                keys.begin(env.num_envs)
            return keys(env.matches, step)

        return play(env, choose, levels)


def drawn_levels(env: FootballVectorEnv, count: int) -> np.ndarray:
    """Return `count` levels: each of the DRAWN scenes once, then again with other seeds."""
    levels = np.zeros(count, level_dtype(env.theta_dim))
    theta = np.random.default_rng(SEED).uniform(-1.0, 1.0, (DRAWN, env.theta_dim))
    levels["theta"] = np.resize(theta, (count, env.theta_dim))
    levels["seed"] = np.arange(SEED, SEED + count)
    return levels


def numbers(episodes: Episodes) -> dict[str, Any]:
    """Return the stored summary of a row's episodes: number, count of each ending, and median length in steps."""
    endings = episodes.endings()
    ended = {word.replace(" ", "_"): int((endings == word).sum()) for word in ENDINGS[1:5]}
    length = float(np.median(episodes.lengths))
    return {"episodes": len(episodes), "goals": int(episodes.scored.sum()), **ended, "median_length": length}


def measure(effort: float = 1.0) -> list[Row]:
    """Compare the goal rates; `effort` below 1 plays fewer episodes."""
    count = max(round(EPISODES * effort), 4)
    return [
        by_distance(
            "academy",
            f"{target['scene']} {target['policy']}",
            float(play_policy(target["scene"], target["policy"], count).scored.mean()),
            int(target["goals"]) / int(target["episodes"]),
            "goal rate",
            TOLERANCE,
        )
        for target in read_data("academy")
    ]


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw goal rates and median lengths of all rows, in the order of the table."""
    targets, count = read_data("academy"), max(round(EPISODES * effort), 4)
    played = [numbers(play_policy(target["scene"], target["policy"], count)) for target in targets]
    order = np.arange(len(targets))
    panels = []
    for title, unit, of in (
        ("goal rate", "", lambda row: int(row["goals"]) / int(row["episodes"])),
        ("median length", "steps", lambda row: float(row["median_length"])),
    ):
        theirs, ours = ([of(row) for row in rows] for rows in (targets, played))
        panels.append(Panel(title, (order, theirs), (order, ours), "row", unit, points=True))
    draw_panels(path, TITLE, panels)


def measure_both(other: FootballConfig, count: int, told: Callable[[int], None]) -> list[dict[str, Any]]:
    """Play all ROWS in both engines, `count` episodes in the other one; return the rows of `data/academy.csv`."""
    rows: list[dict[str, Any]] = []
    for scene, policy in ROWS:
        ours = numbers(play_policy(scene, policy, count * EPISODES // GRF_EPISODES))
        grf = numbers(play_policy(scene, policy, count, other))
        rows.append({"scene": scene, "policy": policy, **grf, **{f"ours_{what}": ours[what] for what in ours}})
        told(len(rows))
    return rows


def table(rows: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return a line for each row, ours and GRF's side by side."""
    lines = [["scene", "policy", "goals, ours", "goals, grf", "length, ours", "length, grf"]]
    for row in rows:
        sides = ("ours_", "")
        goals = [f"{row[f'{side}goals']} of {row[f'{side}episodes']}" for side in sides]
        lines.append([row["scene"], row["policy"], *goals, *(f"{row[f'{side}median_length']:g}" for side in sides)])
    return lines
