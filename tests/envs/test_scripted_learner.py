"""The learner's part played by the program: the yardstick of PAIRED with a scripted antagonist."""

import numpy as np

from envs.football.config import FootballConfig
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


HESITANT = """
model football.model
behavior Hesitate():
    while True:
        take Uniform(1, 3, 5)
        for key in (12, 13):
            take key
ego = LeftCM at 20 @ 0, with behavior Hesitate()
mate = LeftCF at 40 @ 0, with behavior Hesitate()
LeftCB at -20 @ 0
Ball ahead of ego by 1
RightGK at 99 @ 41
"""
SEVERAL = """
model football.model
behavior Sprint():
    while True:
        if self.is_controlled:
            take 5, 13
        else:
            take 19
behavior Leave():
    while True:
        take 19
ego = LeftCM at 20 @ 0, with behavior Sprint()
LeftCF at 40 @ 0, with behavior Leave()
LeftCB at -20 @ 0
Ball ahead of ego by 1
"""


def test_agents_who_do_what_the_program_wants_play_as_it_does():
    env = FootballVectorEnv(HESITANT, 4, config=FootballConfig(control=2))
    env.reset(seed=0)
    script = env.with_scripted_policy()
    seen = set()
    for _ in range(30):
        wanted = env.program_actions()
        assert wanted.shape == (4, 2) and (wanted == env.program_actions()).all()  # asking changes nothing
        seen |= set(wanted.ravel())
        env.step(wanted)
        script.step(np.zeros((4, 2), int))
        for axis in "xy":
            assert (env.matches["players"][axis] == script.matches["players"][axis]).all()
            assert (env.matches["ball"][axis] == script.matches["ball"][axis]).all()
    assert seen == {1, 3, 5, 12, 13}


def test_of_several_actions_an_agent_takes_the_first_and_nothing_for_what_is_left_to_the_ai():
    env = FootballVectorEnv(SEVERAL, 2, config=FootballConfig(control="all"))
    env.reset(seed=0)
    assert env.program_actions().tolist() == [[5, 0, 0]] * 2


def test_a_program_without_behaviors_wants_nothing():
    env = FootballVectorEnv("model football.model\nego = LeftCF at 80 @ 0\nBall ahead of ego by 1\n", 2)
    env.reset(seed=0)
    assert (env.program_actions() == [0, 0]).all()
