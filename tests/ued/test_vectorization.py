"""Gymnasium's own vector environments under a UPOMDP: the same numbers in one process and in several."""

import gymnasium
import numpy as np
import pytest

from ued import DR, PLR, BufferConfig, GymUPOMDP, Paired, PLRConfig, PPOConfig
from ued.core import checkpoint

PPO = PPOConfig(num_steps=32, num_minibatches=1, update_epochs=1, hidden_size=8)
RANGES = {"length": (0.2, 2.0), "gravity": (5.0, 20.0)}


def put(env, values):
    env.unwrapped.length, env.unwrapped.gravity = values["length"], values["gravity"]


def poles(num_envs=3, vectorization="sync"):
    return GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), put, RANGES, num_envs, vectorization)


def put_gravity(env, values):
    env.unwrapped.g = values["g"]


def pendulums(num_envs=4, vectorization="sync"):
    """Return continuous actions, and episodes that are always cut off."""
    return GymUPOMDP(lambda: gymnasium.make("Pendulum-v1"), put_gravity, {"g": (5.0, 15.0)}, num_envs, vectorization)


@pytest.fixture
def both():
    environments = poles(), poles(vectorization="async")
    yield environments
    environments[1].close()


@pytest.mark.slow
def test_processes_give_the_same_numbers(both):
    rng = np.random.default_rng(0)
    firsts = [env.reset(seed=3)[0] for env in both]
    assert (firsts[0] == firsts[1]).all()
    for _ in range(80):
        actions = rng.integers(0, 2, 3)
        one, other = (env.step(actions) for env in both)
        for left, right in zip(one[:4], other[:4], strict=True):
            assert (left == right).all()
        if (one[2] | one[3]).any():
            assert (one[4]["final_obs"] == other[4]["final_obs"]).all()


class Telling(gymnasium.Wrapper):
    """Ends at once and reports whether it succeeded: upright, whatever it is paid."""

    def step(self, action):
        observation, _, terminated, _, info = self.env.step(action)
        return observation, 0.0, terminated, True, info | {"is_success": abs(observation[2]) < 0.1}


@pytest.mark.parametrize("vectorization", ["sync", "async"])
def test_what_environments_say_of_their_success_counts(vectorization):
    env = GymUPOMDP(lambda: Telling(gymnasium.make("CartPole-v1")), put, RANGES, 3, vectorization)
    env.reset(seed=0)
    told = env.step(np.zeros(3, int))[4]
    assert (told["success"] == 1).all()
    assert np.isnan(poles_step()).all()
    env.close()


def poles_step():
    env = poles()
    env.reset(seed=0)
    return env.step(np.zeros(3, int))[4]["success"]


def test_a_level_reaches_its_own_environment_in_another_process(both):
    _, apart = both
    apart.reset(seed=0, options={"theta": [[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]})
    assert [env["length"] for env in apart.describe(apart.levels["theta"])] == pytest.approx([0.2, 1.1, 2.0])
    assert apart.vector.get_attr("length") == pytest.approx((0.2, 1.1, 2.0))
    mask = np.array([False, True, False])
    apart.reset_to_levels(apart.make_levels([[1.0, 1.0]]), mask)
    assert apart.vector.get_attr("length") == pytest.approx((0.2, 2.0, 2.0))


@pytest.mark.long
def test_processes_give_no_state_and_training_resumes_without_it(both, tmp_path):
    with pytest.raises(NotImplementedError, match='support no state; use vectorization="sync"'):
        both[1].get_state()
    method = Paired(both[1], PPO)
    method.update()
    checkpoint.save(tmp_path / "c.pt", method.state_dict(episodes=False))
    resumed = Paired(poles(vectorization="async"), PPO, seed=1)
    resumed.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    assert resumed.update()["env_steps"] == 2 * method.env_steps
    for learner in (*method.learners[1:], *resumed.learners):
        learner.upomdp.close()


def test_another_kind_is_refused():
    with pytest.raises(ValueError, match="vectorization must be sync or async, got 'threads'"):
        poles(vectorization="threads")


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "make", [DR, lambda env, ppo: PLR(env, ppo, PLRConfig(buffer=BufferConfig(capacity=4))), Paired]
)
def test_continuous_actions(make):
    method = make(pendulums(), PPOConfig(num_steps=256, num_minibatches=4, update_epochs=2, hidden_size=8))
    finished = [method.update()["levels"] for _ in range(3)]
    assert sum(finished) > 0 and np.isfinite(list(method.last.returns.values())).all()


@pytest.mark.slow
@pytest.mark.long
def test_ppo_learns_continuous_actions_on_levels_of_any_gravity():
    ppo = PPOConfig(num_steps=200, learning_rate=2e-3, gamma=0.95, num_minibatches=16, update_epochs=8, ent_coef=0.0)
    method = DR(pendulums(16), ppo, seed=1)
    first = np.mean([method.update()["return/student"] for _ in range(2)])
    later = [method.update()["return/student"] for _ in range(24)]
    assert np.mean(later[-4:]) > first + 400


def test_the_params_of_a_scenic_program_set_an_environment(tmp_path):
    from scenic_lite import load

    path = tmp_path / "pole.scenic"
    path.write_text("param gravity = Range(-12, -7)\nparam length = Uniform(0.5, 1.0)\nego = Object at 0 @ 0\n")
    program = load(path)

    def put_params(env, values):
        env.unwrapped.gravity, env.unwrapped.length = -values["gravity"], values["length"]

    env = GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), put_params, program, 4)
    assert len(env.parameters) == 2
    method = DR(env, PPO)
    method.update()
    found = {(e.unwrapped.gravity, e.unwrapped.length) for e in env.vector.envs}
    assert all(7 <= gravity <= 12 and length in (0.5, 1.0) for gravity, length in found) and len(found) == 4
