"""Landers and walkers: environments of others, with discrete and with continuous actions, as UPOMDPs."""

import gymnasium
import numpy as np
import pytest

from ued import DR, PLR, GymUPOMDP, PLRConfig, PPOConfig

pytest.importorskip("Box2D", reason='needs pip install "gymnasium[box2d]"')
PPO = PPOConfig(num_steps=48, num_minibatches=2, update_epochs=1, hidden_size=16)
MOONS = {"gravity": (-11.9, -2.0), "wind": (0.0, 15.0)}


def set_moon(env, values):
    moon = env.unwrapped
    moon.gravity, moon.wind_power, moon.enable_wind = values["gravity"], values["wind"], True


def landers(continuous, num_envs=4):
    return GymUPOMDP(lambda: gymnasium.make("LunarLander-v3", continuous=continuous), set_moon, MOONS, num_envs)


def steps_of_fall(env, theta):
    """Give the steps until the first environment lands or crashes with its engines off, at this θ."""
    env.reset(seed=0, options={"theta": [theta] * env.num_envs})
    for step in range(1, 400):
        _, _, terminated, truncated, _ = env.step(np.zeros(env.num_envs, int))
        if (terminated | truncated)[0]:
            return step
    return 400


def test_theta_sets_the_moon():
    env = landers(continuous=False)
    assert steps_of_fall(env, [-1.0, -1.0]) < steps_of_fall(env, [1.0, -1.0])  # strong gravity, then weak


@pytest.mark.slow
@pytest.mark.parametrize("continuous", [False, True])
def test_students_learn_to_land(continuous):
    env = landers(continuous)
    method = PLR(env, PPO, PLRConfig(score="positive_value_loss"))
    before = [weights.clone() for weights in method.student.parameters()]
    logs = [method.update() for _ in range(6)]
    assert logs[-1]["env_steps"] == 6 * 48 * 4
    assert any((now != old).any() for now, old in zip(method.student.parameters(), before, strict=True))
    assert np.isfinite([log["student/policy_loss"] for log in logs]).all()


def test_a_scenic_program_sets_a_walker(tmp_path):
    """Four continuous actions; how its feet hold is a `param` of the program."""
    from scenic_lite import load

    path = tmp_path / "walker.scenic"
    path.write_text("param friction = Range(0.5, 2.5)\nego = Object at 0 @ 0\n")

    def put(env, values):
        env.unwrapped.fd_polygon.friction = values["friction"]

    env = GymUPOMDP(lambda: gymnasium.make("BipedalWalker-v3"), put, load(path), 2)
    env.reset(seed=0, options={"theta": [[-1.0], [1.0]]})
    assert [walker.unwrapped.fd_polygon.friction for walker in env.vector.envs] == pytest.approx([0.5, 2.5])
    method = DR(env, PPO)
    assert method.update()["env_steps"] == 96
    assert env.single_action_space.shape == (4,)
