"""The rule-based player: needs only raw observations, and beats easy opponents clearly."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.observation.raw import row
from regista.envs.football.vector_env import FootballVectorEnv
from regista.envs.football.view import bot
from regista.envs.football.view.bot import act

EASY = """
param game_duration = 400
param right_team_difficulty = 0.05
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True
LeftGK at -99 @ 0
"""
CLOSE = EASY + "ego = LeftCM at 75 @ 0\nRightGK at -95 @ 3\nball = Ball at 77 @ 0\n"
THREE_VS_ONE = EASY + (
    "ego = LeftCM at 60 @ 0\nLeftCM at 70 @ 20\nLeftCM at 70 @ -20\n"
    "RightGK at 99 @ 0\nRightCB at 75 @ 0\nball = Ball at 62 @ 0\n"
)


def goal_rate(program: str, bot: bool, count: int = 60) -> float:
    env = FootballVectorEnv(program, count, config=FootballConfig(representation="raw", control="active"))
    seen, _ = env.reset(seed=0)
    rng = np.random.default_rng(0)
    goals, over = np.zeros(count, bool), np.zeros(count, bool)
    for _ in range(400):
        actions = rng.integers(0, 19, count)
        if bot:
            actions = np.array([act(row(seen, i)) for i in range(count)])
        seen, rewards, terminated, truncated, _ = env.step(actions)
        goals |= (rewards > 0.5) & ~over
        over |= terminated | truncated
        if over.all():
            break
    return float(goals.mean())


def test_it_knows_nothing_of_this_simulator() -> None:
    tree = ast.parse(Path(bot.__file__).read_text())
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    modules |= {name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names}
    assert modules == {"__future__", "math", "collections.abc", "typing"}


def test_it_plays_from_plain_lists_as_well() -> None:
    """What it reads is indexed, nothing more: an observation that went through JSON gives the same action."""
    env = FootballEnv(THREE_VS_ONE, representation="raw", control="active")
    seen, _ = env.reset(seed=0)
    for _ in range(40):
        plain = json.loads(json.dumps({name: np.asarray(value).tolist() for name, value in seen.items()}))
        action = act(seen)
        assert 0 <= action < 19 and action == act(plain)
        seen, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            break


@pytest.mark.long
def test_it_scores_where_random_play_does_not() -> None:
    assert goal_rate(CLOSE, bot=True) > 0.9 > 0.5 > goal_rate(CLOSE, bot=False)
    # 4 of 20 in Google Research Football
    assert goal_rate(THREE_VS_ONE, bot=True) > 0.1 > 0.05 > goal_rate(THREE_VS_ONE, bot=False, count=400)
