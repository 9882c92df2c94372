"""Vector environments of others play the levels they are given, in every way in which they reset by themselves."""

from functools import partial

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Dict, Discrete
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv, VectorEnv

from tests.ued.test_methods import PPO, numbers
from ued import DR, PLR, BufferConfig, Choice, GymUPOMDP, Integer, Paired, PLRConfig, Range
from ued.adapters.vector import VectorUPOMDP
from ued.core import checkpoint
from ued.core.level_space import LevelError
from ued.core.processes import START_METHOD
from ued.evaluation import evaluate

KINDS = {"length": Integer(1, 5), "pay": Range(0, 1), "ground": Choice("ice", "gravel")}
MODES = list(AutoresetMode)


class Walk(gymnasium.Env):
    """Walks `length` steps, each paid for the action that follows from the seed; gravel truncates, ice terminates."""

    observation_space, action_space = Box(-1, 9, (4,), np.float32), Discrete(2)
    length, pay, ground = 3, 0.0, "ice"

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        for name, value in (options or {}).items():
            setattr(self, name, value)
        self.at, self.luck = 0, self.np_random.random()
        return self.see(), {}

    def step(self, action):
        self.at += 1
        over, reward = self.at >= self.length, self.pay * (action == (self.luck > 0.5))
        info = {"is_success": bool(action)} if over else {}
        return self.see(), reward, over and self.ground == "ice", over and self.ground != "ice", info

    def see(self):
        return np.array([self.at, self.luck, self.length, self.pay], np.float32)


def put(env, values):
    return values


def put_all(vector, where, values):
    """Set the attributes of the environments that are reset, as `set_attr` can: of all, one value each."""
    for name in KINDS:
        column = list(vector.get_attr(name))
        for env, own in zip(where, values, strict=True):
            column[env] = own[name]
        vector.set_attr(name, column)


def options_of(vector, where, values):
    assert len(where) == len(values)
    return {"length": 2}


def sync(mode):
    return lambda count: SyncVectorEnv([Walk] * count, autoreset_mode=mode)


def asynchronous(mode, **settings):
    return lambda count: AsyncVectorEnv([Walk] * count, context=START_METHOD, autoreset_mode=mode, **settings)


def trained(upomdp, method=DR, config=None, updates=3):
    made = method(upomdp, PPO, config, 0)
    found = []
    for _ in range(updates):
        metrics = made.update()
        found.append((numbers(metrics), made.last.records.copy(), made.learners[0].rollout.observation.clone()))
    upomdp.close()
    return found


def assert_alike(ours, theirs):
    for (metrics, records, seen), (others, their_records, they_saw) in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(list(metrics.values()), list(others.values()))
        assert records.tobytes() == their_records.tobytes() and seen.equal(they_saw)


@pytest.fixture(name="reference", scope="module")
def _reference():
    return trained(GymUPOMDP(Walk, put, KINDS, 4))


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize("apply", ["each", put_all])
@pytest.mark.parametrize("mode", MODES)
def test_a_sync_vector_env_trains_as_its_single_environments(mode, apply, reference):
    assert_alike(trained(VectorUPOMDP(sync(mode), apply, KINDS, 4)), reference)


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("mode", MODES)
def test_an_async_vector_env_trains_as_its_single_environments(mode, reference):
    assert_alike(trained(VectorUPOMDP(asynchronous(mode), "each", KINDS, 4)), reference)


@pytest.mark.slow
def test_an_async_vector_env_without_shared_memory(reference):
    plain = asynchronous(AutoresetMode.SAME_STEP, shared_memory=False)
    assert_alike(trained(VectorUPOMDP(plain, put_all, KINDS, 4)), reference)
    with pytest.raises(ValueError, match="with shared_memory=False resets once more after a partial reset"):
        VectorUPOMDP(asynchronous(AutoresetMode.NEXT_STEP, shared_memory=False), "each", KINDS, 1)


class Batch(VectorEnv):
    """Walks of N environments in arrays, which read their levels as arrays from the options of a reset."""

    single_observation_space, single_action_space = Walk.observation_space, Walk.action_space

    def __init__(self, count, mode, resets_all=False):
        self.num_envs, self.resets_all = count, resets_all
        self.metadata = {"autoreset_mode": mode}
        self.walks = [Walk() for _ in range(count)]

    def reset(self, *, seed=None, options=None):
        options = dict(options or {})
        mask = options.pop("reset_mask", np.ones(self.num_envs, bool))
        assert all(column.shape == (self.num_envs,) for column in options.values())
        for env in np.flatnonzero(mask | self.resets_all):
            own = {name: column[env].item() for name, column in options.items()}
            self.walks[env].reset(seed=seed[env], options=own)
        return np.stack([walk.see() for walk in self.walks]), {}

    def step(self, actions):
        seen, *rest, infos = zip(*[walk.step(a) for walk, a in zip(self.walks, actions, strict=True)], strict=True)
        known = np.array(["is_success" in info for info in infos])
        info = {"is_success": np.array([one.get("is_success", 0) for one in infos]), "_is_success": known}
        return np.stack(seen), *map(np.array, rest), info


@pytest.mark.slow
def test_a_batch_that_is_simulated_together_reads_arrays(reference):
    make = lambda count: Batch(count, AutoresetMode.DISABLED)  # noqa: E731
    assert_alike(trained(VectorUPOMDP(make, "arrays", KINDS, 4)), reference)


def test_a_batch_that_cannot_be_reset_in_part_is_refused():
    upomdp = VectorUPOMDP(lambda count: Batch(count, AutoresetMode.NEXT_STEP, resets_all=True), "arrays", KINDS, 4)
    with pytest.raises(LevelError, match=r"environment 1 was reset, too: .* must leave environments outside the mask"):
        upomdp.reset(seed=0)
        upomdp.advance(np.zeros(4, int))
        upomdp.play_again(np.array([True, False, False, False]))


def test_what_a_function_returns_are_options():
    upomdp = VectorUPOMDP(sync(AutoresetMode.DISABLED), options_of, KINDS, 3)
    observation, _ = upomdp.reset(seed=0)
    assert (observation[:, 2] == 2).all()


@pytest.mark.parametrize("mode", MODES)
def test_success_and_last_observations_are_those_of_the_episode_that_ended(mode):
    upomdp = VectorUPOMDP(sync(mode), "each", KINDS, 2)
    theta = [upomdp.theta_of({"length": length, "pay": 1.0, "ground": "gravel"}) for length in (1, 2)]
    upomdp.reset(seed=0, options={"theta": theta})
    seen, _, terminated, truncated, info = upomdp.advance(np.array([1, 1]))
    assert truncated.tolist() == [True, False] and not terminated.any()
    assert seen[:, 0].tolist() == [1, 1] and info["success"][0] == 1 and np.isnan(info["success"][1])
    again = upomdp.play_again(truncated)
    assert again[:, 0].tolist() == [0, 1]
    seen, _, _, truncated, _ = upomdp.advance(np.array([0, 0]))
    assert seen[:, 0].tolist() == [1, 2] and truncated.all()  # nobody lost a step


def test_luck_is_new_in_each_episode_and_layouts_are_not():
    for luck in (False, True):
        upomdp = VectorUPOMDP(sync(AutoresetMode.NEXT_STEP), "each", KINDS, 2, luck=luck)
        first, _ = upomdp.reset(seed=0)
        again = upomdp.play_again()
        assert (again[:, 1] == first[:, 1]).all() == (not luck)


@pytest.mark.slow
def test_two_students_and_a_buffer_and_a_killed_run(tmp_path):
    make = sync(AutoresetMode.SAME_STEP)
    assert trained(VectorUPOMDP(make, "each", KINDS, 4), Paired)[-1][0]["levels"] > 0
    config = PLRConfig(buffer=BufferConfig(capacity=8))
    method = PLR(VectorUPOMDP(make, "each", KINDS, 4), PPO, config, 0)
    method.update()
    checkpoint.save(tmp_path / "c.pt", method.state_dict(episodes=False))
    resumed = PLR(VectorUPOMDP(make, "each", KINDS, 4), PPO, config, 1)
    resumed.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    assert resumed.env_steps == method.env_steps and resumed.update()["levels"] > 0


class Failing(Walk):
    def step(self, action):
        raise ZeroDivisionError("no wind")


class Infinite(Walk):
    def step(self, action):
        return self.see(), float("inf"), False, False, {}


class Unrewarded(SyncVectorEnv):
    def step(self, actions):
        seen, _, *rest = super().step(actions)
        return seen, np.array([0.0, None]), *rest


def test_a_reward_of_none_is_named():
    upomdp = VectorUPOMDP(lambda count: Unrewarded([Walk] * count), "each", KINDS, 2)
    upomdp.reset(seed=0)
    with pytest.raises(LevelError, match=r"environment 1 returned None as its reward, not a number \(level: theta"):
        upomdp.advance(np.zeros(2, int))


@pytest.mark.parametrize(
    ("env", "message"),
    [
        (Failing, r"failed in a step: ZeroDivisionError: no wind \(environment 0, the first of 2; level: theta"),
        (Infinite, r"environment 0 returned a reward that is not finite: inf \(level: theta .*'length'"),
    ],
)
def test_errors_report_the_level(env, message):
    upomdp = VectorUPOMDP(lambda count: SyncVectorEnv([env] * count), "each", KINDS, 2)
    upomdp.reset(seed=0)
    with pytest.raises(LevelError, match=message):
        upomdp.advance(np.zeros(2, int))


def test_an_error_of_the_setter_reports_its_line():
    def broken(vector, where, values):
        values[0]["lenght"]

    upomdp = VectorUPOMDP(lambda count: SyncVectorEnv([Walk] * count), broken, KINDS, 2)
    line = broken.__code__.co_firstlineno + 1
    with pytest.raises(LevelError, match=rf"failed in a reset \({__file__}:{line}\): KeyError: 'lenght'"):
        upomdp.reset(seed=0)


class Nested(Walk):
    observation_space = Dict({"at": Discrete(9)})


@pytest.mark.parametrize(
    ("make", "apply", "message"),
    [
        (lambda count: Walk(), "each", r"make_vector\(2\) must return a gymnasium.vector.VectorEnv, got <"),
        (lambda count: SyncVectorEnv([Walk] * 3), "each", r"make_vector\(2\) must make 2 environments, got 3"),
        (lambda count: SyncVectorEnv([Nested] * 2), "each", "observations must be vectors or images of three axes"),
        (sync(MODES[0]), "all", "apply must be a function, 'each', 'arrays' or None, got 'all'"),
    ],
)
def test_what_cannot_play_levels_is_refused(make, apply, message):
    with pytest.raises(ValueError, match=message):
        VectorUPOMDP(make, apply, KINDS, 2)


@pytest.mark.parametrize("mode", MODES)
def test_an_evaluation_plays_all_its_episodes_in_every_mode(mode):
    def make(count):
        return gymnasium.make_vec("CartPole-v1", count, "sync", vector_kwargs={"autoreset_mode": mode})

    def put(vector, where, values):
        for env, own in zip(where, values, strict=True):
            vector.envs[env].unwrapped.length = own["length"]

    env = VectorUPOMDP(make, put, {"length": (0.2, 2.0)}, num_envs=4)
    student = DR(env, PPO, seed=0).student
    found = evaluate(student, env.copy(), 5, 0)
    assert np.isfinite(found.returns).all() and len(set(found.returns.ravel().tolist())) > 1


class Needy(Walk):
    """Cannot be reset without its options."""

    def reset(self, *, seed=None, options=None):
        options["length"]
        return super().reset(seed=seed, options=options)


def test_each_environment_has_its_options_in_the_first_reset():
    vector = partial(SyncVectorEnv, autoreset_mode=AutoresetMode.DISABLED)
    env = VectorUPOMDP(lambda count: vector([Needy] * count), "each", {"length": (0, 5)}, 2)
    env.reset(seed=0)


class Eaten:
    """Levels that the environment changes while it plays."""

    size = 2

    def sample(self, rng):
        return rng.choice([-1.0, 1.0], 2)

    mutate = staticmethod(lambda level, rng: -level)
    encode = decode = staticmethod(lambda level: level)


def test_an_environment_that_changes_its_level_changes_no_record():
    def eat(vector, where, levels):
        for level in levels:
            level[:] = 0.0

    env = VectorUPOMDP(lambda count: SyncVectorEnv([Walk] * count), eat, Eaten(), 2)
    env.reset(seed=0)
    assert (np.abs(env.levels["theta"]) == 1).all()
