"""What environments are given when they are reset: seeds of levels, luck, levels of a curriculum; one reset each."""

import numpy as np
import pytest
from test_level_identity import BUFFER, METHODS, PPO, SETTINGS, Rooms, Track, Watch, put, rooms

import ued
from ued.adapters.curriculum_wrapper import CurriculumFeed, CurriculumWrapper
from ued.adapters.gym import GymUPOMDP, UPOMDPWrapper
from ued.adapters.mixture import Mixture
from ued.core.curriculum import ThetaSpace
from ued.core.level_space import SEEDS, luck_seed
from ued.methods.paired import PairedCurriculum
from ued.methods.plr import PLRCurriculum

# ---------------------------------------------------------------- what an environment is given


class Given(Rooms):
    """Notes what its reset is given."""

    calls: list = []  # noqa: RUF012

    def reset(self, *, seed=None, options=None):
        Given.calls.append((seed, options))
        return super().reset(seed=seed, options=options)


def given(**settings):
    Given.calls = []
    batch = GymUPOMDP(Given, put, {"rooms": (1, 6)}, 1, **settings)
    batch.reset(seed=0)
    for _ in range(12):
        batch.step(np.array([0]))
    return batch, Given.calls


def test_reset_is_given_the_seed_of_the_level_itself_in_every_episode():
    batch, calls = given()
    assert {seed for seed, _ in calls} == {int(batch.levels["seed"][0])} and len(calls) == 5
    assert all(0 <= seed < SEEDS for seed, _ in calls)


def test_luck_may_be_all_that_reset_draws_or_have_a_seed_of_its_own():
    batch, calls = given(luck=True)
    level = batch.levels["seed"][0]
    assert [seed for seed, _ in calls] == [luck_seed(int(level), 0, episode) for episode in range(5)]
    assert calls[0][0] == level and len({seed for seed, _ in calls}) == 5
    batch, calls = given(luck="weather")
    assert {seed for seed, _ in calls} == {int(batch.levels["seed"][0])}
    lucks = [options["weather"] for _, options in calls]
    assert len({*lucks, int(batch.levels["seed"][0])}) == 6
    noted = []
    batch, calls = given(luck=lambda env, seed: noted.append(seed))
    assert len(set(noted)) == 5 and len({seed for seed, _ in calls}) == 1


@pytest.mark.parametrize(("luck", "rule"), [("", True), (None, True), (3, True), (True, False)])
def test_luck_that_is_none_is_refused(luck, rule):
    with pytest.raises(ValueError, match="luck"):
        GymUPOMDP(Rooms, put, {"rooms": (1, 6)}, 1, luck=luck, seed_episodes=rule)


def test_seeds_are_levels():
    batch = GymUPOMDP(Rooms, None, ued.Seeds(5, first=100), 4)
    levels = batch.sample_levels(200)
    assert set(levels["seed"].tolist()) == {100, 101, 102, 103, 104}
    assert all(row["seed"] == seed for row, seed in zip(batch.describe(levels["theta"]), levels["seed"], strict=True))
    assert batch.make_levels([batch.theta_of({"seed": 103})])["seed"].tolist() == [103]
    for count, first in ((0, 0), (3, -1), (2**31, 1), (2.5, 0), (True, 0)):
        with pytest.raises(ValueError, match="Seeds"):
            ued.Seeds(count, first)


@pytest.mark.slow
@pytest.mark.parametrize(("count", "options"), [(20, 20), (200, 0), (2**31, 0)])
def test_an_adversary_proposes_few_seeds_one_by_one_and_many_as_a_range(count, options):
    batch = GymUPOMDP(Rooms, None, ued.Seeds(count), 4)
    paired = METHODS["paired"].load()(batch, PPO, SETTINGS["paired"], seed=0)
    network = paired.curriculum.adversary.network
    assert network.log_weights.numel() == options and len(network.reals) == (not options)
    for _ in range(3):
        metrics = paired.update()
    assert metrics["adversary/gradient_steps"] > 0
    proposed = batch.make_levels(paired.curriculum.adversary.theta(paired.curriculum.adversary.propose(100)))
    assert proposed["seed"].max() < count and len(set(proposed["seed"].tolist())) > min(count, 50) / 2


@pytest.mark.slow
@pytest.mark.parametrize("method", ["dr", "plr", "paired", "sfl", "accel"])
def test_an_episode_costs_one_reset(method):
    made = METHODS[method].load()(GymUPOMDP(Given, put, {"rooms": (1, 6)}, 4), PPO, SETTINGS.get(method), seed=0)
    Given.calls, ended = [], 0
    for _ in range(5):
        made.update()
        ended += sum(int(learner.worker.rollout.terminated.sum()) for learner in made.learners)
    assert len(Given.calls) == ended > 50


def test_an_evaluation_costs_one_reset_an_episode():
    batch = GymUPOMDP(Given, put, {"rooms": (1, 6)}, 4)
    student = METHODS["dr"].load()(batch, PPO, None, seed=0).student
    tested = GymUPOMDP(Given, put, {"rooms": (1, 6)}, 4)
    Given.calls = []
    levels = tested.sample_levels(5)
    played = ued.evaluate(student, tested, 40, 7, levels)
    assert len(Given.calls) == 40 and played.env_steps == played.lengths.sum()
    assert {seed for seed, _ in Given.calls} == set(levels["seed"].tolist())


# ---------------------------------------------------------------- other people's trainers


def test_a_wrapped_environment_plays_the_levels_of_a_curriculum():
    Given.calls = []
    curriculum = PLRCurriculum(ThetaSpace({"rooms": (1, 6)}), ued.PLRConfig(score="learnability", episodes_per_level=2))
    env = CurriculumWrapper(UPOMDPWrapper(Given(), put, {"rooms": (1, 6)}, luck="weather"), CurriculumFeed(curriculum))
    played = []
    for _ in range(12):
        env.reset(seed=5)
        played.append(int(env.record["level"]["seed"][0]))
        while not env.step(0)[2]:
            pass
    assert [seed for seed, _ in Given.calls] == played and len(set(played)) == 6
    assert len({options["weather"] for _, options in Given.calls}) == 12


def test_a_wrapped_environment_repeats_a_level():
    env = UPOMDPWrapper(Rooms(), put, {"rooms": (1, 6)}, luck="weather")
    seen, info = env.reset(seed=4)
    again, told = env.reset(options={"level": env.level})
    assert (seen == again).all() and told["level_seed"] == info["level_seed"] == 4
    first = env.unwrapped.luck
    assert (env.reset_agent() == seen).all() and env.unwrapped.luck != first
    env.reset(options={"level": env.level, "visit": 1})
    assert env.unwrapped.luck != first


@pytest.mark.slow
def test_stable_baselines_and_torchrl_play_levels_with_layouts():
    stable = pytest.importorskip("stable_baselines3")
    pytest.importorskip("torchrl")
    from ued.adapters.sb3 import SB3VecEnv
    from ued.adapters.torchrl import TorchRLEnv

    batch = rooms()
    pool = batch.sample_levels(3)
    watch = Watch()
    watch._over_one(0, batch)
    batch.level_sampler = lambda count: pool[np.random.default_rng(0).integers(0, 3, count)]
    stable.PPO("MlpPolicy", SB3VecEnv(batch), n_steps=16, batch_size=32, seed=0).learn(128)
    TorchRLEnv(batch).rollout(40, break_when_any_done=False)
    assert all(len({start.layout for start in of_level}) == 1 for of_level in watch.starts.values())
    lucks = [start.luck for key in map(batch.key_of, pool) for start in watch.starts[key]]
    assert len(lucks) == len(set(lucks)) > 20


# ---------------------------------------------------------------- edges


@pytest.mark.slow
def test_members_of_a_mixture_keep_the_seeds_that_their_levels_are():
    method = METHODS["accel"].load()(
        Mixture([GymUPOMDP(Rooms, None, ued.Seeds(5), 4), GymUPOMDP(Rooms, None, ued.Seeds(5, 100), 4)], ["a", "b"]),
        PPO,
        SETTINGS["accel"],
        seed=0,
    )
    for _ in range(8):
        method.update()
        levels = method.last.records["level"]
        values = method.upomdp.describe(levels["theta"])
        assert [row["seed"] for row in values] == levels["seed"].tolist()


def test_levels_of_no_seeded_episodes_are_told_apart_by_theta():
    batch = GymUPOMDP(Rooms, put, {"rooms": ued.Integer(1, 2)}, 4, seed_episodes=False)
    method = METHODS["plr"].load()(batch, PPO, ued.PLRConfig(buffer=BUFFER), seed=0)
    for _ in range(4):
        method.update()
    assert len(method.buffer) == 2


class Lent(Track):
    """Hands out its own array, and writes into it again."""

    def _observe(self):
        self.room = getattr(self, "room", np.zeros((self.num_envs, 3), np.float32))
        self.room[:] = super()._observe()
        return self.room


def test_final_observations_are_those_of_the_end():
    batch = Lent(2)
    batch.reset(seed=0)
    for _ in range(6):
        observations, _, terminated, _, info = batch.step(np.zeros(2, int))
        if terminated.any():
            assert (info["final_obs"][terminated, 2] == 3).all() and (observations[terminated, 2] == 0).all()
            return
    raise AssertionError("no episode has ended")


def test_what_a_luck_function_returns_is_seen_first():
    batch = GymUPOMDP(Rooms, put, {"rooms": (1, 6)}, 1, luck=lambda env, seed: np.full(4, 0.5, np.float32))
    assert (batch.reset(seed=0)[0] == 0.5).all()


def test_a_level_of_another_kind_is_refused_by_a_wrapper():
    env = UPOMDPWrapper(Rooms(), put, {"rooms": (1, 6)})
    env.reset(seed=0)
    with pytest.raises(ValueError, match="one record of"):
        env.reset(options={"level": np.zeros(1, ued.level_dtype(3))})
    with pytest.raises(ValueError, match="visit must be"):
        env.reset(options={"visit": -1})


def test_a_feed_goes_on_with_its_visits():
    def feed():
        return CurriculumFeed(
            PLRCurriculum(ThetaSpace({"rooms": (1, 6)}), ued.PLRConfig(score="learnability", episodes_per_level=2))
        )

    one, other = feed(), feed()
    given = [one.next() for _ in range(3)]
    given[1]["returns"], given[1]["num_played"] = 1.0, 2
    one.finish(given[1])
    given[0]["num_played"] = 1  # its first episode is lost with its environment
    other.load_state_dict(one.state_dict())
    assert len(other.finished) == 1 and other.finished["visit"][0] == 1
    again = [other.next() for _ in range(3)]
    assert [int(record["visit"][0]) for record in again] == [0, 2, 3]  # those that were being played, then a new one
    assert again[0]["level"] == given[0]["level"] and again[0]["num_played"] == 0


def test_a_level_that_was_left_is_given_out_again():
    feed = CurriculumFeed(PLRCurriculum(ThetaSpace({"rooms": (1, 6)}), ued.PLRConfig(score="max_mc")))
    env = CurriculumWrapper(UPOMDPWrapper(Rooms(), put, {"rooms": (1, 6)}), feed)
    env.reset(seed=0)
    left = env.record["level"].copy()
    env.reset(options={"theta": [0.0]})
    env.reset()
    assert env.record["level"] == left


def test_a_feed_has_one_student():
    with pytest.raises(ValueError, match="the trainer has one student, PairedCurriculum needs 2"):
        CurriculumFeed(PairedCurriculum(ThetaSpace(1), ued.PairedConfig()))


def test_seeds_are_levels_without_environments_too():
    space = ThetaSpace(ued.Seeds(5))
    levels = space.sample_levels(400)
    assert set(levels["seed"].tolist()) == set(range(5))
    assert [row["seed"] for row in space.describe(levels["theta"])] == levels["seed"].tolist()
