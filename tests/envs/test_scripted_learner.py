"""The learner's part played by the program: the yardstick of PAIRED with a scripted antagonist."""

import numpy as np

from envs.football.vector_env import FootballVectorEnv

RUNNER = """
model football.model
behavior Run():
    while True:
        take 5
ego = LeftCM at 20 @ 0, with behavior Run()
Ball ahead of ego by 1
RightGK at 99 @ 41
"""


def moved(env):
    before = env.matches["players"]["x"][:, 0].copy()
    for _ in range(10):
        env.step(np.full(env.num_envs, 1))  # to the left
    return env.matches["players"]["x"][:, 0] - before


def test_a_behavior_plays_the_learners_player_whatever_the_actions():
    env = FootballVectorEnv(RUNNER, 3)
    env.reset(seed=0)
    script = env.with_scripted_policy()
    assert (moved(env) < 0).all() and (moved(script) > 0).all()
    assert (script.levels == env.levels).all()
    assert (moved(script.copy()) > 0).all()


def test_without_a_behavior_the_built_in_player_has_it():
    env = FootballVectorEnv("model football.model\nego = LeftCF at 80 @ 0\nBall ahead of ego by 1\n", 2)
    env.reset(seed=0)
    script = env.with_scripted_policy()
    rewards = sum(script.step(np.zeros(2, int))[1] for _ in range(60))
    assert (rewards > 0).all()
