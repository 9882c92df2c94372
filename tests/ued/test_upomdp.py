"""The seam itself, on CartPole: levels, validity, autoreset, the thesis's names, and what is refused."""

import threading

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.utils.env_checker import check_env

from ued import DR, Paired, PPOConfig
from ued.adapters.gym import GymUPOMDP, UPOMDPWrapper
from ued.core.level_space import ThetaError, check_theta

RANGES = {"length": (0.2, 2.0), "push": (2.0, 15.0)}


def put(env, values):
    env.unwrapped.length = values["length"]
    env.unwrapped.force_mag = values["push"]


def cartpole(num_envs=4, theta=RANGES):
    return GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), put, theta, num_envs)


class NoShortPoles:
    """A stand-in for a program: two columns, and poles under a third of the range are invalid."""

    def __init__(self):
        self.draws = cartpole(1).parameters

    def valid(self, theta):
        return theta[:, 0] > -1 / 3

    def describe(self, row):
        return {"length": float(row[0] + 2), "push": float(row[1] * 5 + 10)}


def test_theta_reaches_the_environment_in_the_users_units():
    env = cartpole(2)
    env.reset(options={"theta": [[-1.0, 1.0], [1.0, 0.0]]})
    assert [e.unwrapped.length for e in env.vector.envs] == [0.2, 2.0]
    assert [e.unwrapped.force_mag for e in env.vector.envs] == [15.0, 8.5]
    assert env.describe([[1.0, 0.0]]) == [{"length": 2.0, "push": 8.5}]


def test_an_ended_episode_restarts_on_its_own_level_in_the_same_step():
    env = cartpole(3)
    env.reset(seed=0)
    before = env.levels.copy()
    while True:
        observations, _, terminated, truncated, info = env.step(np.ones(3, int))
        ended = terminated | truncated
        if ended.any():
            break
    assert (info["_final_obs"] == ended).all()
    assert (np.abs(info["final_obs"][ended, 2]) > 0.2).all()  # fallen: beyond 12 degrees
    assert (np.abs(observations[ended]) <= 0.05).all()  # CartPole starts within 0.05
    assert (env.levels == before).all()


def test_level_sampler_supplies_the_level_of_the_next_episode():
    env = cartpole(3)
    env.reset(seed=0)
    asked = []

    def supply(count):
        asked.append(count)
        return env.make_levels(np.full((count, 2), 0.5))

    env.level_sampler = supply
    for _ in range(30):
        before = env.levels.copy()
        ended = np.logical_or(*env.step(np.ones(3, int))[2:4])
        assert (env.levels[~ended] == before[~ended]).all()
        assert (env.levels["theta"][ended] == 0.5).all()
    assert sum(asked) > 3


def test_an_invalid_level_is_replaced_and_reported():
    env = cartpole(4, NoShortPoles())
    env.reset(seed=3)
    theta = np.array([[-0.9, 0.0], [0.5, 0.0], [-0.5, 0.2], [0.0, 0.0]])
    assert env.valid(theta).tolist() == [False, True, False, True]
    _, info = env.reset_to_levels(env.make_levels(theta))
    assert info["replaced"].tolist() == [True, False, True, False]
    assert env.valid(info["levels"]["theta"]).all()
    assert (info["levels"]["theta"][~info["replaced"]] == theta[[1, 3]]).all()
    assert (env.levels == info["levels"]).all()


def test_sampling_gives_up_with_a_sentence_when_nothing_is_valid(monkeypatch):
    monkeypatch.setattr("ued.core.level_space.MAX_TRIES", 20)
    env = cartpole(2, NoShortPoles())
    env.theta_map.valid = lambda theta: np.zeros(len(theta), bool)
    with pytest.raises(ThetaError, match=r"no valid theta found in 20 draws for 2 of 2 rows"):
        env.reset(seed=0)


def test_the_same_seed_gives_the_same_levels_and_observations():
    one, two = cartpole(), cartpole()
    assert (one.reset(seed=5)[0] == two.reset(seed=5)[0]).all()
    assert (one.levels == two.levels).all()
    assert (one.reset(seed=6)[0] != two.reset(seed=5)[0]).any()


def test_a_list_of_seeds_is_one_seed_and_a_list_of_none_is_none():
    one, two = cartpole(), cartpole()
    one.reset(seed=[1, None, 2, 3]), two.reset(seed=[1, None, 2, 3])
    assert (one.levels == two.levels).all()
    one.reset(seed=5), two.reset(seed=6)
    one.reset(seed=[None] * 4), two.reset(seed=[None] * 4)
    assert (one.levels != two.levels).all()  # each goes on with its own stream


def test_a_reset_mask_leaves_the_others_alone():
    env = cartpole()
    env.reset(seed=1)
    before = env.levels.copy()
    mask = np.array([True, False, False, True])
    env.reset(options={"theta": [[0.1, 0.1], [0.2, 0.2]], "reset_mask": mask})
    assert (env.levels[~mask] == before[~mask]).all()
    assert env.levels["theta"][mask].tolist() == [[0.1, 0.1], [0.2, 0.2]]


def test_a_student_looks_as_close_as_needs_be_where_no_unit_is_known():
    """A pole falls at 0.05 rad: with a floor of 0.1 for an angle, PPO no longer solves CartPole."""
    assert cartpole().observation_scale is None
    assert DR(cartpole(), seed=0).student.normaliser.floor.tolist() == [0, 0, 0, 0]


def test_the_thesis_names():
    env = cartpole(2)
    env.reset_random()
    theta = [[0.25, -0.25], [0.75, -0.75]]
    env.step_adversary(theta)
    assert env.levels["theta"].tolist() == theta
    env.reset_agent()
    assert env.levels["theta"].tolist() == theta


def test_a_copy_resumes_bit_for_bit_and_independently():
    env = cartpole()
    env.reset(seed=2)
    env.step(np.zeros(4, int))
    twin = env.copy()
    for env_or_twin in (env, twin):
        env_or_twin.level_sampler = env_or_twin.sample_levels
    for step in range(60):
        actions = np.full(4, step // 7 % 2)
        left, right = env.step(actions), twin.step(actions)
        assert all((a == b).all() for a, b in zip(left[:4], right[:4], strict=True))
    assert (env.levels == twin.levels).all()


@pytest.mark.parametrize(
    ("theta", "message"),
    [
        (np.zeros((2, 3)), "theta must have shape [2, 2], got [2, 3]"),
        (np.zeros((3, 2)), "theta must have shape [2, 2], got [3, 2]"),
        (np.zeros((2, 2, 1)), "theta must have shape [2, 2], got [2, 2, 1]"),
        ([[0, 0], [0, float("nan")]], "theta[1, 1] is nan; every entry must be a number in [-1, 1]"),
        ([[0, 0], [1.5, 0]], "theta[1, 0] is 1.5; every entry must be a number in [-1, 1]"),
        ([[0, 0], [0, float("-inf")]], "theta[1, 1] is -inf; every entry must be a number in [-1, 1]"),
        ("level", "theta must be an array of numbers of shape [N, 2], got 'level'"),
    ],
)
def test_a_theta_that_is_none_is_refused(theta, message):
    env = cartpole(2)
    env.reset(seed=0)
    before = env.levels.copy()
    with pytest.raises(ThetaError) as error:
        env.step_adversary(theta)
    assert str(error.value) == message
    assert (env.levels == before).all()


def test_levels_of_another_kind_or_number_are_refused():
    env = cartpole(2)
    with pytest.raises(ValueError, match="2 environments need as many levels"):
        env.reset_to_levels(env.make_levels(np.zeros((3, 2))))
    with pytest.raises(ValueError, match="levels must be records of"):
        env.reset_to_levels(np.zeros((2, 2)))


def test_one_row_counts_as_a_batch_of_one():
    assert check_theta([0.5, -0.5], 2).shape == (1, 2)
    assert check_theta(np.zeros((3, 0)), 0).shape == (3, 0)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_the_single_wrapper_stays_a_gymnasium_environment():
    env = UPOMDPWrapper(gymnasium.make("CartPole-v1"), put, RANGES)
    check_env(env, skip_render_check=True)
    _, info = env.reset(options={"theta": [1.0, -1.0]})
    assert (env.unwrapped.length, env.unwrapped.force_mag) == (2.0, 2.0)
    assert info["theta"].tolist() == [1.0, -1.0]
    with pytest.raises(ThetaError, match=r"theta\[0, 0\] is 2"):
        env.reset(options={"theta": [2.0, 0.0]})
    invalid = UPOMDPWrapper(gymnasium.make("CartPole-v1"), put, NoShortPoles())
    with pytest.raises(ValueError, match="is not a valid level"):
        invalid.step_adversary([-0.9, 0.0])


# ---------------------------------------------------------------- what other people's environments hold


class Odd(gymnasium.Env):
    """Three steps; shows what it is told to show, and holds something that cannot be copied."""

    action_space = gymnasium.spaces.Discrete(2)

    def __init__(self, space):
        self.observation_space, self.window = space, threading.Lock()

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.observation_space.seed(seed)
        self.t = 0
        return self.observation_space.sample(), {}

    def step(self, action):
        self.t += 1
        return self.observation_space.sample(), 1.0, self.t == 3, False, {}


def odd(space):
    return GymUPOMDP(lambda: Odd(space), lambda env, values: None, 1, 2)


def test_environments_that_cannot_be_copied_begin_their_levels_anew_in_the_copy():
    env = odd(Box(-1, 1, (2,)))
    method = Paired(env, PPOConfig(num_steps=8, hidden_size=4, num_minibatches=1), seed=0)
    assert method.update()["env_steps"] == 32
    twin = env.copy()
    assert (twin.levels == env.levels).all() and twin.vector.envs[0].unwrapped.t == 0
    with pytest.raises(NotImplementedError, match=r"cannot be copied: cannot pickle .*lock"):
        env.get_state()


def test_grey_images_get_a_channel_and_are_seen_as_images():
    env = odd(Box(0, 255, (12, 10), np.uint8))
    assert env.single_observation_space.shape == (12, 10, 1)
    assert DR(env, PPOConfig(num_steps=4, hidden_size=4), seed=0).update()["env_steps"] == 8


def test_observations_without_a_size_are_refused_by_name():
    class Words(gymnasium.Space):  # as some packages write them, who do not say whether they can be flattened
        pass

    space = gymnasium.spaces.Dict({"seen": Box(-1, 1, (2,)), "mission": Words()})
    with pytest.raises(ValueError, match=r"observations\['mission'\] must have a fixed size, got .*Words"):
        odd(space)
