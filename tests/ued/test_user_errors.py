"""What a user's code returns or raises wrongly is an error that says where; names of any kind survive tables."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

import ued
from regista.experiments.run.report import as_markdown
from regista.experiments.run.table import Table, read_columns
from ued.core.own_code import OwnCodeError
from ued.core.parameters import cells_in, columns_of

VECTOR = Box(-1, 1, (2,), np.float32)


class Env(gymnasium.Env):
    """An episode of two steps, which returns `reward` and `info`; an exception among them is raised."""

    observation_space, action_space = VECTOR, Discrete(2)

    def __init__(self, reward, info):
        self.given = reward, info

    def reset(self, *, seed=None, options=None):
        self.t = 0
        return np.zeros(2, np.float32), {}

    def step(self, action):
        self.t += 1
        reward, info = self.given
        if isinstance(reward, Exception):
            raise reward
        return np.zeros(2, np.float32), reward, self.t == 2, False, info


def put(env, values):
    env.unwrapped.level = values


@pytest.mark.parametrize(
    ("reward", "info", "message"),
    [
        (np.ones(1), {}, r"Env failed in step: ValueError: the reward must be a number, got array\(\[1\.\]\)"),
        ([1.0], {}, r"the reward must be a number, got \[1\.0\]"),
        (1.0, {"success": np.array([True])}, r"info\['success'\] must be a number, got array\(\[ True\]\)"),
        (1.0, {"is_success": "yes"}, r"info\['is_success'\] must be a number, got 'yes'"),
        (StopIteration("no more rows"), {}, r"failed in step .*: StopIteration: no more rows \(level: theta"),
    ],
)
def test_a_wrong_step_reports_the_level(reward, info, message):
    batch = ued.GymUPOMDP(lambda: Env(reward, info), put, {"a": (0, 1)}, 2)
    batch.reset(seed=0)
    with pytest.raises(ued.LevelError, match=message) as caught:
        batch.advance(np.zeros(2, int))
    assert "seed" in str(caught.value)


@pytest.mark.parametrize("reward", [1, 1.0, np.float32(1), np.array(1.0), True])
@pytest.mark.parametrize("info", [{"success": np.bool_(True)}, {"success": np.array(1)}, {"success": None}, {}])
def test_numbers_of_every_type_are_accepted(reward, info):
    batch = ued.GymUPOMDP(lambda: Env(reward, info), put, {"a": (0, 1)}, 2)
    batch.reset(seed=0)
    assert batch.advance(np.zeros(2, int))[1].tolist() == [1, 1]


class Batch(VectorEnv):
    """Two environments; `wrong` is the index in the result of a step that `value` replaces."""

    def __init__(self, num_envs, wrong, value):
        self.num_envs, self.wrong, self.value = num_envs, wrong, value
        self.metadata = {"autoreset_mode": AutoresetMode.DISABLED}
        self.single_observation_space, self.single_action_space = VECTOR, Discrete(2)
        self.observation_space, self.action_space = batch_space(VECTOR, num_envs), batch_space(Discrete(2), num_envs)

    def reset(self, *, seed=None, options=None):
        return np.zeros((self.num_envs, 2), np.float32), {}

    def step(self, actions):
        on = np.ones(self.num_envs, bool)
        result = [np.zeros((self.num_envs, 2), np.float32), np.ones(self.num_envs), on, ~on, {}]
        result[self.wrong] = self.value
        return tuple(result)


@pytest.mark.parametrize(
    ("wrong", "value", "message"),
    [
        (0, np.zeros((1, 2), np.float32), r"observations must have shape \(2, 2\), got \(1, 2\)"),
        (1, np.ones((2, 1)), r"rewards must have shape \(2,\), got \(2, 1\)"),
        (1, 1.0, r"rewards must have shape \(2,\), got \(\)"),
        (2, False, r"terminated must have shape \(2,\), got \(\)"),
        (3, np.ones((2, 1), bool), r"truncated must have shape \(2,\), got \(2, 1\)"),
        (4, {"success": ["yes", "no"]}, r"info\['success'\] must be numbers, got \['yes', 'no'\]"),
        (4, {"success": [1.0]}, r"info\['success'\] must have shape \(2,\), got \(1,\)"),
    ],
)
def test_a_wrong_step_of_a_vector_environment_names_the_part(wrong, value, message):
    batch = ued.VectorUPOMDP(lambda n: Batch(n, wrong, value), "arrays", {"a": (0, 1)}, 2)
    batch.reset(seed=0)
    with pytest.raises(ued.LevelError, match=message):
        batch.advance(np.zeros(2, int))


class Pairs:
    """A family whose functions fail one by one."""

    size, broken = 2, ""

    def sample(self, rng):
        return self.fail("sample", rng.random(2))

    def mutate(self, level, rng):
        return self.fail("mutate", level)

    def encode(self, level):
        return self.fail("encode", level)

    def decode(self, code):
        return self.fail("decode", code)

    def fail(self, name, value):
        if name == self.broken:
            raise IndexError("no such place")
        return value


@pytest.mark.parametrize("broken", ["sample", "mutate", "encode", "decode"])
def test_an_error_of_a_family_names_function_and_line(broken):
    space = ued.ThetaSpace(Pairs())
    codes = space.sample_levels(1)["theta"]
    space.level_family.broken = broken
    with pytest.raises(OwnCodeError, match=rf"{broken} failed \(.*test_user_errors.py:\d+\): IndexError: no such"):
        space.edit_theta(space.sample_theta(1) if broken == "sample" else codes, 1, 0.1, np.random.default_rng(0))


def test_an_error_of_valid_reports_the_values():
    batch = ued.GymUPOMDP(lambda: Env(1.0, {}), put, {"a": (0, 1)}, 1, valid=lambda values: values["b"])
    with pytest.raises(OwnCodeError, match=r"valid failed \(.*\.py:\d+\): KeyError: 'b' \(called with \{'a': 0\."):
        batch.reset(seed=0)


class Pickled(gymnasium.utils.EzPickle, Env):
    """An environment whose copy is a new environment, as those of Box2D and MuJoCo; its observation is its level."""

    def __init__(self):
        gymnasium.utils.EzPickle.__init__(self)
        Env.__init__(self, 1.0, {})
        self.level, self.t = {"a": 0.0}, 0

    def step(self, action):
        return np.full(2, self.level["a"], np.float32), *super().step(action)[1:]


def test_a_copy_of_environments_that_pickle_their_arguments_plays_the_same_levels():
    batch = ued.GymUPOMDP(Pickled, put, {"a": (0.5, 1)}, 2)
    batch.reset(seed=0)
    twin = batch.copy()
    np.testing.assert_array_equal(twin.advance(np.zeros(2, int))[0], batch.advance(np.zeros(2, int))[0])
    with pytest.raises(NotImplementedError, match=r"Pickled cannot be copied: it is a gymnasium\.utils\.EzPickle"):
        batch.get_state()


# ---------------------------------------------------------------- names


@pytest.mark.parametrize("name", ["", " ", "two\nlines", 7])
def test_a_parameter_has_a_name_of_one_line(name):
    with pytest.raises(ValueError, match="the name of a parameter must be a line of text, got"):
        columns_of({name: (0, 1)})


def test_options_have_different_names_of_one_line():
    (column,) = columns_of({"map": ued.Choice("#.\n.#", "#. .#", 'a "b"', 1, "1")})
    assert cells_in(column).names == ("#. .# [0]", "#. .# [1]", 'a "b"', "1 [3]", "1 [4]")


def test_a_table_with_quotes_in_a_name_can_be_read(tmp_path):
    table = Table(tmp_path / "t.csv")
    names = ['eval/the "hard" one, again', 'x"', '"']
    table.append([{"update": 1, **dict.fromkeys(names, 0.5)}])
    table.append([{"update": 2, "text": 'a "b", c'}])
    assert Table(tmp_path / "t.csv").columns == ["update", *names, "text"]
    assert [read_columns(tmp_path / "t.csv")[name][0] for name in names] == [0.5] * 3


def test_a_bar_in_a_name_is_no_cell_of_a_markdown_table():
    assert as_markdown([["a|b", "c"]]).splitlines() == [r"| a\|b | c |", "|---|---|"]
