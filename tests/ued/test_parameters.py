"""Parameters of every kind, through the methods; levels that are no vector; errors that tell the level."""

import copy
import threading
from dataclasses import replace
from functools import partial

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete

from ued import (
    ACCEL,
    METHODS,
    ACCELConfig,
    AdversaryConfig,
    BufferConfig,
    Choice,
    GymUPOMDP,
    Integer,
    LevelError,
    LogRange,
    NCCConfig,
    Paired,
    PairedConfig,
    PPOConfig,
    Range,
    SFLConfig,
    ThetaSpace,
)
from ued.core.parameters import ThetaMap, edit, quantize
from ued.core.processes import START_METHOD
from ued.core.upomdp import UPOMDP
from ued.levels.diagnostics import theta_metrics

KINDS = {"gravity": Range(5, 15), "mass": LogRange(0.1, 10), "legs": Integer(2, 6), "ground": Choice("grass", "ice")}
SMALL = PPOConfig(num_steps=8, hidden_size=8, update_epochs=1, num_minibatches=1)


class Bandit(gymnasium.Env):
    """One step; pays 1 for action 1 where the ground is ice, for action 0 elsewhere."""

    observation_space = Box(0.0, 1.0, (1,), np.float32)
    action_space = Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(1, np.float32), {}

    def step(self, action):
        return np.zeros(1, np.float32), float(action == (self.values["ground"] == "ice")), True, False, {}


def put(env, values):
    env.unwrapped.values = values


def bandit(num_envs=4, **more):
    return GymUPOMDP(Bandit, put, KINDS, num_envs, **more)


def test_each_kind_means_what_it_says_at_the_ends_and_in_the_middle():
    rows = bandit().describe([[-1.0] * 4, [0.0] * 4, [1.0] * 4])
    assert rows[0] == {"gravity": 5.0, "mass": 0.1, "legs": 2, "ground": "grass"}
    assert rows[1] == {"gravity": 10.0, "mass": pytest.approx(1.0), "legs": 4, "ground": "ice"}
    assert rows[2] == {"gravity": 15.0, "mass": pytest.approx(10.0), "legs": 6, "ground": "ice"}


def test_values_have_a_theta_and_come_back_from_it():
    values = {"gravity": 9.81, "mass": 0.5, "legs": 5, "ground": "ice"}
    theta = bandit().theta_of(values)
    assert bandit().describe(theta)[0] == pytest.approx(values)
    with pytest.raises(ValueError, match="a level needs a value for each of gravity, mass, legs, ground"):
        bandit().theta_of({"gravity": 9.81})


@pytest.mark.parametrize("about", [(0.0, np.inf), (2.0, 1.0), "ice", (1, 2, 3), None])
def test_what_is_no_kind_is_refused(about):
    with pytest.raises(ValueError, match=r"'push' must be a Range, LogRange, Integer, Choice or a pair"):
        ThetaMap({"push": about})


def test_equal_levels_are_one_level():
    env = GymUPOMDP(Bandit, put, {"legs": Integer(1, 3), "ground": Choice("grass", "ice")}, 2)
    levels = env.make_levels(np.random.default_rng(0).uniform(-1, 1, (500, 2)))
    assert len(np.unique(levels["theta"], axis=0)) == 6
    assert (quantize(levels["theta"], env.parameters) == levels["theta"]).all()
    assert [env.describe(row)[0] for row in levels["theta"]] == env.describe(levels["theta"])


def test_edits_stay_within_the_kind():
    space, rng = ThetaSpace(KINDS | {"floor": Integer(0, 99)}), np.random.default_rng(0)
    theta = space.sample_levels(3000)["theta"]
    edited = edit(theta, space.parameters, 1, 0.1, rng)
    assert (quantize(edited, space.parameters)[:, 2:] == edited[:, 2:]).all()
    changed = edited != theta
    assert (changed.sum(1) == 1).all()  # an edit of a value is another value
    floors = (edited - theta)[changed[:, 4], 4] * 100 / 2
    assert set(np.abs(floors).round().astype(int)) == {1, 2, 3, 4, 5}
    assert len(np.unique(np.round(edited[changed[:, 3], 3], 6))) == 2  # of two grounds, the other


@pytest.mark.slow
def test_the_adversary_is_categorical_where_the_parameter_is():
    method = Paired(bandit(), SMALL, PairedConfig(dr_fraction=0.0), seed=0)
    teacher = method.curriculum
    network = teacher.adversary.network
    assert [(part.column, part.cells.count) for part in network.choices] == [(2, 5), (3, 2)]
    assert [part.column for part in network.reals] == [0, 1]
    records = teacher.propose(200)
    theta = records["level"]["theta"]
    assert (theta[:, 2:] == quantize(theta, method.upomdp.parameters)[:, 2:]).all()
    for column, cells in ((2, 5), (3, 2)):
        assert len(np.unique(theta[:, column])) == cells
    score = (theta[:, 3] > 0).astype(float)  # ice is worth more
    for _ in range(15):
        losses = teacher.learn(records, score)
        records = teacher.propose(200)
        score = (records["level"]["theta"][:, 3] > 0).astype(float)
    assert score.mean() > 0.8 and losses["adversary/entropy"] < 4 * np.log(2)


@pytest.mark.parametrize("distribution", ["program", "tanh_gaussian", "beta"])
def test_a_fresh_adversary_has_nearly_the_entropy_of_the_uniform(distribution):
    config = PairedConfig(dr_fraction=0.0, adversary=AdversaryConfig(distribution=distribution, update_epochs=1))
    teacher = Paired(bandit(), SMALL, config, seed=0).curriculum
    records = teacher.propose(2000)
    losses = teacher.learn(records, np.random.default_rng(0).random(2000))
    assert losses["adversary/entropy"] == pytest.approx(4 * np.log(2), abs=0.25)


def test_entropy_and_coverage_count_the_values_of_a_column():
    space = ThetaSpace(KINDS)
    theta = space.sample_levels(2000)["theta"]
    metrics = theta_metrics(theta, space.parameters)
    assert metrics["theta_entropy"] == pytest.approx(4 * np.log(2), abs=0.02) and metrics["theta_coverage"] == 1.0
    half = theta[theta[:, 3] > 0]  # one value of two: log 2 less, and one cell of 10 + 10 + 5 + 2
    metrics = theta_metrics(half, space.parameters)
    assert metrics["theta_entropy"] == pytest.approx(3 * np.log(2), abs=0.03)
    assert metrics["theta_coverage"] == pytest.approx(26 / 27, abs=1e-3)


def test_what_is_no_level_is_never_played():
    env = bandit(8, valid=lambda values: not (values["ground"] == "ice" and values["legs"] > 3))
    env.reset(seed=0)
    for row in env.describe(env.sample_theta(300)):
        assert row["ground"] == "grass" or row["legs"] <= 3
    assert not env.valid(env.theta_of({"gravity": 9.0, "mass": 1.0, "legs": 4, "ground": "ice"})).any()


# ---------------------------------------------------------------- levels that are no vector


class Words:
    """Levels that are words of three letters of two."""

    size = 3

    def sample(self, rng):
        return "".join(rng.choice(["a", "b"], 3))

    def mutate(self, level, rng):
        k = rng.integers(3)
        return level[:k] + ("a" if level[k] == "b" else "b") + level[k + 1 :]

    def encode(self, level):
        return np.array([1.0 if letter == "a" else -1.0 for letter in level])

    def decode(self, code):
        return "".join("a" if x > 0 else "b" for x in code)


def words(num_envs=4):
    return GymUPOMDP(
        Bandit, lambda env, word: put(env, {"ground": "ice" if word[0] == "a" else "grass"}), Words(), num_envs
    )


@pytest.mark.parametrize("name", ["dr", "plr", "robust_plr", "accel", "sfl", "ncc"])
def test_levels_of_a_family_are_drawn_stored_and_mutated(name):
    buffer = BufferConfig(capacity=8)
    settings = {
        "plr": METHODS["plr"].settings().__class__(buffer=buffer),
        "accel": ACCELConfig(buffer=buffer, num_edits=1),
        "sfl": SFLConfig(candidates=8, chosen=4, choose_every=2),
        "ncc": NCCConfig(capacity=8, episodes_per_level=2),
    }
    method = METHODS[name].load()(words(), SMALL, settings.get(METHODS[name].group), seed=0)
    for _ in range(6):
        metrics = method.update()
        assert set(np.unique(method.last.theta)) <= {-1.0, 1.0}
    assert "theta_entropy" not in metrics  # a code has none that means anything
    if name in ("plr", "accel", "ncc"):
        buffer = method.curriculum.buffer
        assert len(np.unique(buffer.slots["level"]["theta"], axis=0)) == len(buffer) <= 8


def test_mutants_differ_in_one_letter():
    method = ACCEL(words(), SMALL, ACCELConfig(num_edits=1), seed=0)
    theta = method.upomdp.sample_theta(50)
    moved = method.upomdp.edit_theta(theta, 1, 0.2, np.random.default_rng(0)) != theta
    assert (moved.sum(1) == 1).all()


@pytest.mark.parametrize("name", ["paired", "minimax", "repaired", "self_regret", "alp_gmm"])
def test_who_places_levels_says_that_these_cannot_be_placed(name):
    with pytest.raises(
        ValueError, match="levels of Words can be sampled and mutated, but not chosen by theta; use dr, plr"
    ):
        METHODS[name].load()(words(), SMALL, None, seed=0)


# ---------------------------------------------------------------- every size, every method


class Silent(UPOMDP):
    """One step, pays for the first column of θ."""

    def __init__(self, theta, num_envs=4):
        self.map = ThetaMap(theta)
        super().__init__(num_envs, Box(-1, 1, (1,), np.float32), Discrete(2), self.map.draws)

    def _start(self, levels, where):
        return np.zeros((self.num_envs, 1), np.float32)

    def _advance(self, actions):
        reward = (np.asarray(actions) == (self.levels["theta"][:, 0] > 0)).astype(float)
        over, seen = np.ones(self.num_envs, bool), np.zeros((self.num_envs, 1), np.float32)
        return seen, reward, over, ~over, {}

    def copy(self):
        return copy.deepcopy(self)


def mixed(dim):
    kinds = (Range(0, 1), LogRange(1, 100), Integer(0, 4), Choice("a", "b", "c"), Integer(-1000, 1000))
    return {f"p{i}": kinds[i % len(kinds)] for i in range(dim)}


@pytest.mark.slow
@pytest.mark.sample(21)
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("dim", [1, 5, pytest.param(10_000, marks=[pytest.mark.slow, pytest.mark.long])])
def test_theta_of_any_size_and_mixture_through_every_method(name, dim):
    buffer, row = BufferConfig(capacity=8), METHODS[name]
    settings = row.settings()
    if hasattr(settings, "buffer"):
        settings = settings.__class__(buffer=buffer)
    elif name == "sfl":
        settings = SFLConfig(candidates=8, chosen=4, choose_every=2)
    elif name == "ncc":
        settings = NCCConfig(capacity=8)
    if hasattr(settings, "adversary"):
        settings = replace(settings, adversary=AdversaryConfig(update_epochs=2))
    method = row.load()(Silent(mixed(dim)), SMALL, settings, seed=0)
    for _ in range(3):
        metrics = method.update()
    theta = method.last.theta
    assert theta.shape[1] == dim and len(theta) and (quantize(theta, method.upomdp.parameters) == theta).all()
    assert metrics["theta_entropy"] <= dim * np.log(2) + 1e-6


# ---------------------------------------------------------------- other spaces, other seeds, errors


class Everything(gymnasium.Env):
    """Observations and actions of several kinds; remembers what it was given."""

    def __init__(self, action_space, options=None):
        self.observation_space = Dict({"word": Discrete(3), "flags": MultiBinary(2), "at": Box(-1, 1, (2, 2))})
        self.action_space = action_space
        self.given = []

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.given.append((seed, options))
        return self.observation_space.sample(), {}

    def step(self, action):
        assert self.action_space.contains(action), action
        return self.observation_space.sample(), 1.0, True, False, {}


@pytest.mark.parametrize(
    "action_space",
    [MultiDiscrete([3, 4]), MultiBinary(3), Box(-1, 1, (2, 3), np.float32), Discrete(3, start=-1)],
    ids=str,
)
def test_a_student_learns_from_dicts_and_sends_actions_of_every_kind(action_space):
    env = GymUPOMDP(lambda: Everything(action_space), lambda env, values: None, 1, 3)
    assert env.single_observation_space.shape == (3 + 2 + 4,)
    metrics = ACCEL(env, SMALL, ACCELConfig(buffer=BufferConfig(capacity=4)), seed=0).update()
    assert np.isfinite(metrics["student/entropy"]) if "student/entropy" in metrics else metrics["env_steps"] == 24


def test_a_setter_may_give_options_and_a_rule_may_change_the_seed():
    def apply(env, values):
        return {"config": {"lanes": values["lanes"]}}

    def env_of(rule):
        env = GymUPOMDP(lambda: Everything(Discrete(2)), apply, {"lanes": Integer(1, 3)}, 1, seed_episodes=rule)
        env.reset(options={"theta": [[1.0]]})
        return env.vector.envs[0].unwrapped.given[-1]

    seed, options = env_of(True)
    assert seed is not None and options == {"config": {"lanes": 3}}
    assert env_of(False)[0] is None
    assert env_of(lambda seed: 7)[0] == 7


class Broken(Bandit):
    """Fails where the ground is ice."""

    def step(self, action):
        if self.values["ground"] == "ice":
            raise ZeroDivisionError("the ice broke")
        return super().step(action)


@pytest.mark.parametrize("vectorization", ["sync", "async"])
def test_an_error_tells_the_level(vectorization):
    env = GymUPOMDP(Broken, put, KINDS, 2, vectorization)
    env.reset(seed=0, options={"theta": [[0.0, 0.0, 0.0, -1.0], [0.5, 0.0, 0.0, 1.0]]})
    message = (
        r"^Broken failed in step \(.*test_parameters.py:\d+\): ZeroDivisionError: the ice broke "
        r"\(level: theta \[0.5, 0, 0, 0.5\], that is .*'ice'"
    )
    with pytest.raises(LevelError, match=message):
        env.step(np.zeros(2, int))
    env.close()


def test_an_error_of_the_setter_tells_the_environment_the_line_and_the_level():
    def broken(env, values):
        values["lenght"]

    line = broken.__code__.co_firstlineno + 1
    message = (
        rf"^CartPole-v1 failed in the function that applies levels \({__file__}:{line}\): KeyError: 'lenght' \(level"
    )
    with pytest.raises(LevelError, match=message):
        GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), broken, {"length": (0.1, 2.0)}, 1).reset(seed=0)


def test_a_setter_of_too_few_arguments_tells_its_definition():
    def alone(env):
        """Take no values."""

    line = alone.__code__.co_firstlineno
    with pytest.raises(LevelError, match=rf"\({__file__}:{line}\): TypeError: .*alone\(\) takes 1 positional"):
        GymUPOMDP(Bandit, partial(alone), KINDS, 1).reset(seed=0)


@pytest.mark.skipif(START_METHOD != "fork", reason="processes elsewhere are sent what makes their environments")
def test_processes_make_environments_that_cannot_be_pickled():
    """On every Python: from 3.14 on processes do not fork unless told to."""
    lock = threading.Lock()

    def make_env():
        with lock:
            return Bandit()

    env = GymUPOMDP(make_env, put, KINDS, 2, "async")
    env.reset(seed=0)
    env.close()
