"""What a match of football pays its agents, and when an episode is a success."""

import numpy as np
import pytest

from regista import minigames
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import DIRECTION_RIGHT, SHOT
from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.vector_env import FootballVectorEnv


def test_a_goal_pays_one_and_says_so():
    env = FootballEnv(minigames.MINIGAMES["1v1Restricted"].tests[0][1])
    for seed in range(20):
        env.reset(seed=seed)
        env.step(DIRECTION_RIGHT)
        over = False
        while not over:
            _, reward, terminated, truncated, info = env.step(SHOT)
            over = terminated or truncated
            assert reward in (-1.0, 0.0, 1.0)
            assert (info["ended"] == "goal") == (reward != 0)
        if reward == 1:
            return
    pytest.fail("no goal in 20 attempts at an open goal")


OPEN_GOAL = """
model football.model
param end_episode_on_score = True
param game_duration = 60
param defending = {defending}
{side}GK
{side}CM at {x} @ 0
ego = Ball at {ball} @ 0
{others}
"""


def open_goal(ahead, defending, others="RightGK at 99 @ 41", **settings):
    """Return a left player before the goal that he attacks, or a right one before the other; nobody is in the way."""
    place = {"side": "Left", "x": 88, "ball": 91} if ahead else {"side": "Right", "x": -88, "ball": -91}
    text = OPEN_GOAL.format(defending=defending, others=others, **place)
    return FootballVectorEnv(text.replace("GK\n", "GK at 0 @ 41\n", 1), 8, config=FootballConfig(**settings))


def endings(env, action):
    """Return and success of the first episode of each match."""
    env.reset(seed=0)
    total, success = np.zeros(8), np.full(8, np.nan)
    for _ in range(60):
        _, reward, terminated, truncated, info = env.step(np.full(8, action))
        ended = (terminated | truncated) & np.isnan(success)
        total[np.isnan(success)] += reward[np.isnan(success)]
        success[ended] = info["success"][ended]
    return total, success


@pytest.mark.parametrize("rewards", ["scoring", "scoring,checkpoints"])
def test_an_attack_succeeds_by_a_goal_whatever_pays(rewards):
    total, success = endings(open_goal(True, False, rewards=rewards), SHOT)
    assert success.any() and (success == (total >= 1)).all()
    total, success = endings(open_goal(True, False, rewards=rewards), 0)
    assert not success.any()


def test_a_defence_succeeds_where_no_goal_is_conceded():
    learner = "LeftCM at 60 @ 20"
    total, success = endings(open_goal(False, True, learner), 0)
    assert (total == -1).any() and (success == (total == 0)).all()
    assert (endings(open_goal(True, True), 0)[1] == 1).all()
    assert not endings(open_goal(False, False, learner), 0)[1].any()


def test_where_a_program_pays_its_pay_is_the_success():
    monitor = (
        "monitor Pay():\n    while True:\n        simulation().scenic_reward = 0.5\n        wait\nrequire monitor Pay()"
    )
    total, success = endings(open_goal(True, False, f"RightGK at 99 @ 41\n{monitor}"), 0)
    assert (total > 0).all() and np.isnan(success).all()


def test_a_program_that_only_reads_its_pay_sets_none():
    monitor = "monitor Look():\n    while simulation().scenic_reward > 1:\n        wait\nrequire monitor Look()"
    assert not open_goal(True, False, f"RightGK at 99 @ 41\n{monitor}").behaviors.sets_reward
