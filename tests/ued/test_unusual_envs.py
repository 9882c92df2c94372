"""Environments that are unusual, but allowed: their values arrive whole, in training and in a loaded policy."""

import warnings

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete
from test_parameters import Silent

import ued
from ued.adapters.policy import LoadedPolicy
from ued.adapters.sb3 import SB3VecEnv
from ued.core.baselines import UniformPolicy
from ued.core.parameters import Choice, Column, Integer, LogRange
from ued.core.seeding import torch_generator
from ued.learning.student import Student
from ued.lesson_config import lesson_of
from ued.levels.regions import region_of
from ued.probes import Frontier

BRIEF = ued.PPOConfig(num_steps=4, num_minibatches=1, update_epochs=1, hidden_size=8)
VECTOR = Box(-1, 1, (2,), np.float32)


def ignore(env, values):
    """Apply no level: all are alike."""


class Env(gymnasium.Env):
    """Lasts `length` steps, and reports what a test wants."""

    observation_space, action_space, length = VECTOR, Discrete(2), 2

    def reset(self, *, seed=None, options=None):
        self.t = 0
        return self.see(), {}

    def step(self, action):
        self.t += 1
        return self.see(), 1.0, self.t >= self.length, False, self.info()

    def see(self):
        return np.zeros(2, np.float32)

    def info(self):
        return {}


# ---------------------------------------------------------------- training


class Ends(Silent):
    """Truncates episodes, and says so in numbers of a type."""

    kind: type = bool

    def _advance(self, actions):
        seen, reward, over, _, info = super()._advance(actions)
        return seen + 1, reward, np.zeros(self.num_envs, self.kind), over.astype(self.kind), info


@pytest.mark.parametrize("kind", [bool, np.int64, np.uint8])
def test_ends_may_be_numbers(kind):
    env = Ends({"a": ued.Range(0, 1)})
    env.kind = kind
    method = ued.DR(env, BRIEF, seed=0)
    method.collect_rollouts()
    assert method.learners[0].rollout.truncated.all() and (method.learners[0].rollout.final_value != 0).all()


def test_arrays_of_any_length_may_be_in_the_info():
    class Growing(Env):
        def info(self):
            return {"path": np.zeros(self.t), "success": 1.0}

    method = ued.DR(ued.GymUPOMDP(Growing, ignore, 1, 3), BRIEF, seed=0)
    method.update()
    assert (method.last.records["success"][:, 0, 0] == 1.0).all()


class Double(Env):
    """Observes float64: an offset and a random number."""

    observation_space, offset = Box(-np.inf, np.inf, (2,), np.float64), 0.0

    def see(self):
        return np.array([0.0, self.offset + self.np_random.random()])


@pytest.mark.parametrize(("offset", "told"), [(1e3, False), (1e9, True)])
def test_observations_that_float32_rounds_away_are_named(offset, told):
    class Far(Double):
        pass

    Far.offset = offset
    method = ued.DR(ued.GymUPOMDP(Far, ignore, 1, 8), BRIEF, seed=0)
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        for _ in range(2):
            method.update()
    texts = [str(one.message) for one in heard if "float32" in str(one.message)]
    assert len(texts) == told and all("rounds entry 1 of observations, near 1e+09, by more than 1%" in t for t in texts)


@pytest.mark.parametrize("vectorized", [False, True])
def test_observations_that_float32_cannot_hold_are_refused(vectorized):
    class Huge(Double):
        offset = 1e300

    def many(count):
        return gymnasium.vector.SyncVectorEnv([Huge] * count, autoreset_mode=gymnasium.vector.AutoresetMode.DISABLED)

    env = ued.VectorUPOMDP(many, "each", 1, 2) if vectorized else ued.GymUPOMDP(Huge, ignore, 1, 2)
    message = r"environment 0 returned an observation that is too large for float32 \(scale it .*\(level: theta \["
    with pytest.raises(ued.LevelError, match=message):
        env.reset(seed=0)


def test_a_luck_function_returns_an_observation_of_the_environment_itself():
    class Parted(Env):
        observation_space = Dict(a=VECTOR, b=Discrete(3, start=1))

        def see(self):
            return {"a": np.array([getattr(self, "x", 0.0), 0.0], np.float32), "b": 2}

    def luck(env, seed):
        env.unwrapped.x = 0.5
        return env.unwrapped.see()

    seen, _ = ued.GymUPOMDP(Parted, ignore, 1, 2, luck=luck).reset(seed=0)
    assert seen.tolist() == [[0.5, 0.0, 0.0, 1.0, 0.0]] * 2


def test_environments_are_copied_before_their_first_reset():
    ued.GymUPOMDP(Env, ignore, 1, 2).copy().reset(seed=0)


def student(observations, actions=Discrete(2)):  # noqa: B008 - nobody changes it
    return Student(observations, actions, BRIEF, torch_generator(0))


def test_integers_are_acted_on_evenly():
    actions = torch.linspace(-1, 1, 8001)[:, None]
    values, counts = np.unique(student(VECTOR, Box(0, 4, (1,), np.int64)).to_environment(actions), return_counts=True)
    assert values.tolist() == [0, 1, 2, 3, 4] and np.ptp(counts[1:-1]) <= 2  # the ends are half as wide


def test_a_box_as_wide_as_its_type_is_unbounded():
    most = np.finfo(np.float32).max
    acted = student(VECTOR, Box(-most, most, (1,), np.float32)).to_environment(torch.tensor([[0.0], [0.3]]))
    assert acted.ravel() == pytest.approx([0.0, 0.3])


def test_a_uniform_policy_begins_where_its_actions_do():
    actions = UniformPolicy(Discrete(3, start=1)).play(np.zeros((100, 1)), torch_generator(0))
    assert set(actions.tolist()) == {1, 2, 3}


def test_stable_baselines_begins_on_the_levels_of_the_users_sampler():
    env = Frontier(3)
    env.level_sampler = lambda count: env.make_levels(np.full((count, env.theta_dim), 0.25))
    first = env.make_levels(np.full((1, env.theta_dim), 0.25))["theta"]
    SB3VecEnv(env).reset()
    assert (env.levels["theta"] == first).all()


# ---------------------------------------------------------------- levels


class Third(Silent):
    """Levels are valid below a third of the values."""

    def valid(self, theta):
        return np.asarray(theta)[:, 0] < 0.3


def test_records_name_the_levels_that_are_played():
    env = Third({"n": Integer(0, 4)}, 16)
    method = ued.DR(env, BRIEF, seed=0)
    method.update()
    assert env.valid(method.last.theta).all()


def test_values_are_those_of_their_kinds():
    env = Silent({"a": ued.Range(0, 1)})
    env.parameters = (
        Column("mass", LogRange(0.1, 10)),
        Column("legs", Integer(2, 6)),
        Column("on", Choice("ice", "mud")),
    )
    env.theta_map = None
    (found,) = env.describe([[0.0, -0.8, -0.5]])
    assert found == {"mass": pytest.approx(1.0), "legs": 2, "on": "ice"}
    region = region_of(env, lesson_of("mass=0.1..1 until steps 5"))
    assert (region.low[0], region.high[0]) == pytest.approx((-1.0, 0.0))


# ---------------------------------------------------------------- a loaded policy


@pytest.mark.parametrize(
    ("space", "observation"),
    [
        (MultiDiscrete([3, 2]), np.array([2, 1])),
        (Box(-1, 1, (2, 2), np.float32), np.zeros((2, 2), np.float32)),
        (Box(0, 255, (36, 36), np.uint8), np.zeros((36, 36), np.uint8)),
        (Discrete(4), 2),
        (MultiBinary(3), np.zeros(3, np.int8)),
        (Dict(a=VECTOR, b=Discrete(3)), {"a": np.zeros(2, np.float32), "b": 1}),
        (VECTOR, np.zeros(2, np.float32)),
    ],
)
def test_a_policy_reads_what_its_environment_shows(space, observation):
    class Shows(Env):
        observation_space = space

        def see(self):
            return observation

    seen = ued.GymUPOMDP(Shows, ignore, 1, 1).single_observation_space
    policy = LoadedPolicy(student(seen), seen.shape, space, 0)
    assert np.shape(policy.act(observation)) == ()
    if not isinstance(observation, dict):
        assert policy.act(np.stack([observation] * 3)).shape == (3,)


def test_four_observations_of_four_values_are_four():
    policy = LoadedPolicy(student(Box(0, 1, (4,), np.int64)), (4,), Discrete(4), 0)
    assert policy.act(np.array([0, 1, 2, 3])).shape == (4,)
