"""The learner's part played by the program: the yardstick of PAIRED with a scripted antagonist."""

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import (
    BUILTIN_AI,
    DIRECTION_BOTTOM_LEFT,
    DIRECTION_TOP_LEFT,
    NO_ACTION,
    RELEASE_DIRECTION,
    SHOT,
    SLIDING,
)
from regista.envs.football.control.actions import desired_action
from regista.envs.football.physics.motion import SLIDE
from regista.envs.football.state import MATCH
from regista.envs.football.vector_env import FootballVectorEnv

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


def test_whom_an_agent_leaves_to_the_built_in_ai_kicks_as_it_does():
    """Only the mates of a learner leave the ball to him."""
    env = FootballVectorEnv(
        "model football.model\nego = LeftCF at 88 @ 0\nBall ahead of ego by 1\nRightGK at 99 @ 0\n", 8
    )
    env.reset(seed=0)
    script = env.with_scripted_policy()
    told = [script.step(np.zeros(8, int))[4]["agent_actions"] for _ in range(30)]
    assert (np.array(told) == SHOT).any(0).all()


RUNNERS = """
model football.model
param agents_only = {only}
behavior Run():
    while True:
        take 3
ego = LeftCM at 20 @ 0, with behavior Run()
LeftCF at 40 @ 0, with behavior Run()
RightCB at 60 @ 0, with behavior Run()
Ball ahead of ego by 1
"""


@pytest.mark.parametrize("only, commanded", [(False, [3, 3, 7]), (True, [3, BUILTIN_AI, 7])])
def test_agents_only_leaves_the_mates_of_agents_to_the_built_in_ai(only, commanded):
    env = FootballVectorEnv(RUNNERS.format(only=only), 1)
    env.reset(seed=0)
    assert env.program_actions().tolist() == [3]
    env.step(np.array([3]))
    assert env.matches["players"]["action"][0, :3].tolist() == commanded


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


@pytest.mark.slow
def test_a_program_without_behaviors_wants_nothing():
    env = FootballVectorEnv("model football.model\nego = LeftCF at 80 @ 0\nBall ahead of ego by 1\n", 2)
    env.reset(seed=0)
    assert (env.program_actions() == [0, 0]).all()


# ---------------------------------------------------------------- what its agents see, and what was done for them


@pytest.mark.parametrize(("program", "control"), [(HESITANT, "2"), (HESITANT, "closest1"), (RUNNER, "active")])
def test_agents_keep_their_players_and_their_views_while_the_program_plays(program, control):
    env = FootballVectorEnv(program, 3, config=FootballConfig(control=control))
    env.reset(seed=1)
    script = env.with_scripted_policy()
    for _ in range(30):
        seen, *_ = env.step(env.program_actions())
        view, _, _, _, info = script.step(np.zeros(env.action_space.shape, int))
        assert (view == seen).all() and np.abs(view).sum() > 0
        assert (script.matches["agents"] == env.matches["agents"]).all()
        assert (info["agent_actions"] >= 0).all()


def test_what_was_done_for_an_agent_is_what_it_would_have_done():
    env = FootballVectorEnv(HESITANT, 4, config=FootballConfig(control=2))
    env.reset(seed=0)
    script = env.with_scripted_policy()
    for _ in range(20):
        wanted = script.program_actions()
        assert (script.step(wanted)[4]["agent_actions"] == wanted).all()
        assert (env.step(np.full((4, 2), 7))[4]["agent_actions"] == 7).all()  # and an agent's own


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("5, 13", [5, 13, 5, 5]),  # what changes something first, then all is as wanted
        ("13, 5, 12", [12, 12, 12, 12]),
        ("14", [14, 14, 14, 14]),
        ("5, 14", [5, 5, 5, 5]),
    ],
)
def test_of_several_keys_the_one_that_says_most_is_told(command, told):
    program = f"model football.model\nbehavior B():\n    while True:\n        take {command}\n"
    program += "ego = LeftCM at 20 @ 0, with behavior B()\nBall at 0 @ 20\nRightGK at 99 @ 0\n"
    env = FootballVectorEnv(program, 1)
    env.reset(seed=0)
    script = env.with_scripted_policy()
    for key in told:
        assert env.program_actions() == script.program_actions() == key
        assert script.step(np.zeros(1, int))[4]["agent_actions"] == key
        env.step(np.array([key]))


@pytest.mark.parametrize("side", ["Left", "Right"])
def test_the_built_in_players_wish_is_told_as_the_nearest_key(side):
    x, control = (20, ("1", "none")) if side == "Left" else (-20, ("none", "1"))
    program = f"model football.model\nego = {side}CF at {x} @ 0\nBall at {1.08 * x} @ 0\n"
    env = FootballVectorEnv(program, 1, config=FootballConfig(control=control[0], right_control=control[1]))
    env.reset(seed=0)
    script = env.with_scripted_policy()
    told = [int(script.step(np.zeros(1, int))[4]["agent_actions"][0, 0]) for _ in range(12)]
    assert told == [5, 5, 5, 13] * 3  # towards the goal that he attacks, at a sprint


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"kick": SHOT, "desired_vx": 8.0}, SHOT),  # as when he takes a set piece
        ({"is_sliding": True, "down_wait": SLIDE.time}, SLIDING),
        ({"down_wait": 0.3, "desired_vx": 8.0}, NO_ACTION),
        ({"desired_vx": 0.2}, RELEASE_DIRECTION),
        ({"desired_vx": -3.0, "desired_vy": -3.1}, DIRECTION_BOTTOM_LEFT),
        ({"desired_vx": -3.0, "desired_vy": 3.1}, DIRECTION_TOP_LEFT),
    ],
)
def test_wishes_of_built_in_players_as_keys(fields, told):
    player = np.zeros(1, MATCH).view(np.recarray)[0].players[0]
    for name, value in fields.items():
        player[name] = value
    assert desired_action(player, 0) == told


def test_what_a_program_did_last_is_repeated_where_actions_stick():
    program = "model football.model\nparam sticky_noise = 0.5\nLeftGK\nego = LeftCF at 70 @ 0\n"
    program += "Ball at 72 @ 0\nRightGK\nRightCB at 80 @ 1\n"
    env = FootballVectorEnv(program, 64, config=FootballConfig(control="all"))
    env.reset(seed=0)
    script = env.with_scripted_policy()
    told = [script.step(np.zeros((64, 2), int))[4]["agent_actions"] for _ in range(100)]  # raises for a fault
    assert np.mean([one == two for one, two in zip(told[1:], told, strict=False)]) > 0.6
