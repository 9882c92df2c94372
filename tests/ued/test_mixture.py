"""Several programs in one batch, the program a part of the level."""

from functools import partial

import gymnasium
import numpy as np
import pytest
import torch
from probes import Choice, Endless, HalfValid, Landscape

from ued import ACCEL, DR, ACCELConfig, BufferConfig, Paired, PLRConfig, PPOConfig, RobustPLR
from ued.adapters.gym import GymUPOMDP
from ued.adapters.mixture import Mixture
from ued.config import AdversaryConfig
from ued.core import parameters as kinds
from ued.core.parameters import Column
from ued.evaluation import evaluate
from ued.levels.adversary import Adversary
from ued.probes import Frontier

PPO = PPOConfig(num_steps=32, num_minibatches=1, update_epochs=1, hidden_size=8)


def mixture(num_envs=12):
    """Mix two-action, three-step landscapes: two of two columns, half of one's levels invalid, and one of no column."""
    return Mixture([Landscape(num_envs), HalfValid(num_envs), Choice(num_envs)], ["plain", "half", "choice"])


def test_theta_chooses_the_program_and_the_program_its_own_columns():
    env = mixture(3)
    env.reset(seed=0, options={"theta": [[-1.0, 0.1, 0.2], [0.0, 0.3, -0.4], [1.0, 0.5, 0.5]]})
    assert env.levels["program"].tolist() == [0, 1, 2]
    assert env.members[0].levels["theta"][0].tolist() == [0.1, 0.2]
    assert env.members[1].levels["theta"][1].tolist() == [0.3, -0.4]
    assert [member.idle.tolist() for member in env.members] == [
        [False, True, True],
        [True, False, True],
        [True, True, False],
    ]
    assert [each["program"] for each in env.describe(env.levels["theta"])] == ["plain", "half", "choice"]
    assert set(env.describe(env.levels["theta"])[2]) == {"program"}


def test_validity_is_that_of_the_program():
    env = mixture()
    theta = np.array([[-0.9, -0.5, 0.0], [0.0, -0.5, 0.0], [0.0, 0.5, 0.0], [0.9, -0.5, 0.0]])
    assert env.valid(theta).tolist() == [True, False, True, True]
    env.reset(seed=0)
    drawn = env.sample_levels(600)
    assert env.valid(drawn["theta"]).all()
    assert np.bincount(drawn["program"]) / 600 == pytest.approx([0.4, 0.2, 0.4], abs=0.06)


def test_observations_say_which_program_it_is():
    env = mixture(3)
    seen, _ = env.reset(seed=0, options={"theta": [[-1.0, 0.1, 0.2], [0.0, 0.3, -0.4], [1.0, 0.5, 0.5]]})
    assert seen.shape == (3, 5)
    assert seen[0] == pytest.approx([0.1, 0.2, 1, 0, 0]) and seen[1] == pytest.approx([0.3, -0.4, 0, 1, 0])
    assert seen[2].tolist() == [0, 0, 0, 0, 1]
    assert env.observation_space.contains(seen)


def test_the_unit_of_an_entry_is_the_least_of_its_programs(monkeypatch):
    env = mixture(3)
    units = np.array([0.5, 2.0]), np.array([1.0, 0.1]), None
    for member, unit in zip(env.members, units, strict=True):
        monkeypatch.setattr(type(member), "observation_scale", unit)
    assert env.observation_scale.tolist() == [0.0, 0.1, 1, 1, 1]


def test_each_program_prefetches_the_levels_of_its_own(monkeypatch):
    env, coming = mixture(3), {}
    for k, member in enumerate(env.members):
        monkeypatch.setattr(member, "prefetch", partial(coming.__setitem__, k))
    levels = env.make_levels([[-1.0, 0.1, 0.2], [0.0, 0.3, -0.4], [1.0, 0.5, 0.5], [-1.0, 0.6, 0.7]])
    env.prefetch(levels)
    plain, half, choice = (coming[k] for k in range(3))
    assert plain["theta"].tolist() == [[0.1, 0.2], [0.6, 0.7]] and half["theta"].tolist() == [[0.3, -0.4]]
    assert plain["seed"].tolist() == levels["seed"][[0, 3]].tolist() and len(choice) == 1


def test_each_environment_gets_the_rewards_of_its_program():
    env = mixture(30)
    env.reset(seed=1)
    for _ in range(20):
        actions = np.zeros(30, int)
        _, reward, terminated, truncated, info = env.step(actions)
        choice = env.levels["program"] == 2
        assert (reward[choice] == -1).all() and terminated[choice].all()
        assert (reward[~choice] >= 0).all() and not truncated.any()
        ended = terminated | truncated
        assert (info["final_obs"][ended, 2:].argmax(1) == env.levels["program"][ended]).all()
        env.reset_to_levels(env.sample_levels(int(ended.sum())), ended)


class Defence(Choice):
    """What pays -1 is a failure, what pays nothing is none."""

    def _advance(self, actions):
        observation, reward, *over, info = super()._advance(actions)
        return observation, np.minimum(reward, 0.0), *over, info | {"success": (reward > 0).astype(float)}


def test_success_is_what_each_program_says_or_a_positive_return():
    env = Mixture([Choice(8), Defence(8)], ["attack", "defence"])
    evaluation = evaluate(Constantly(1), env, 40, 0)
    defence = env.program_of(evaluation.levels["theta"]) == 1
    assert 0 < defence.sum() < 40 and (evaluation.returns == np.where(defence, 0.0, 1.0)).all()
    assert (evaluation.success == 1).all()
    assert (evaluate(Constantly(0), env, 40, 0).success == 0).all()
    levels = DR(env, PPO)
    assert 0 < levels.update()["success"] < 1


class Constantly:
    """A policy of one action."""

    def __init__(self, action):
        self.action = action

    def empty_memory(self, num_envs):
        return torch.zeros(num_envs, 0)

    def play(self, observation, generator, greedy, memory):
        return np.full(len(observation), self.action)


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "make",
    [
        lambda env: Paired(env, PPO),
        lambda env: ACCEL(env, PPO, ACCELConfig(buffer=BufferConfig(capacity=32))),
    ],
)
def test_methods_train_on_it_and_resume(make):
    method, resumed = make(mixture()), make(mixture())
    for _ in range(4):
        method.update()
    resumed.load_state_dict(method.state_dict())
    one, other = method.update(), resumed.update()
    assert all(one[k] == other[k] or one[k] != one[k] for k in one if not k.startswith("time/"))
    assert one["env_steps"] == 5 * 32 * 12 * len(method.learners)
    assert sum(one[f"program/{name}"] for name in ("plain", "half", "choice")) == pytest.approx(1)
    assert 0 <= one["program_success/choice"] <= 1


def test_a_program_alone_is_seen_as_in_the_mixture():
    whole = mixture(3)
    alone = Mixture(whole.members, whole.program_names, only=1)
    assert alone.observation_space == whole.observation_space
    assert set(alone.sample_levels(50)["program"].tolist()) == {1}
    seen, _ = alone.reset(seed=0, options={"theta": [[-1.0, 0.3, -0.4]] * 3})
    assert seen[0] == pytest.approx([0.3, -0.4, 0, 1, 0])
    assert alone.copy().only == 1


def test_members_must_go_together():
    with pytest.raises(ValueError, match=r"frontier has actions Discrete\(4\), plain Discrete\(2\)"):
        Mixture([Landscape(4), Frontier(4)], ["plain", "frontier"])
    with pytest.raises(ValueError, match="choice has 5 environments, plain 4"):
        Mixture([Landscape(4), Choice(5)], ["plain", "choice"])
    with pytest.raises(ValueError, match="one name for each member"):
        Mixture([Landscape(4), Endless(4)], ["a", "a"])


@pytest.mark.slow
def test_minigames_of_football_in_one_batch():
    from regista.envs.football.vector_env import FootballVectorEnv
    from regista.minigames.suites import MINIGAMES

    names = ["1v1Restricted", "1v1Free"]
    env = Mixture([FootballVectorEnv(MINIGAMES[name].program, 16) for name in names], names)
    env.reset(seed=0)
    assert len(set(env.levels["program"].tolist())) == 2
    total = np.zeros(16)
    for _ in range(50):
        seen, reward, *_ = env.step(np.full(16, 5))
        total += reward
        assert np.isfinite(seen).all()
    alone = FootballVectorEnv(MINIGAMES["1v1Free"].program, 16)
    assert alone.single_observation_space.shape[0] + 2 <= seen.shape[1]
    assert {each["program"] for each in env.describe(env.levels["theta"])} == set(names)


def test_an_adversary_chooses_among_programs_without_parameters():
    draws, generator = [Column("program", kinds.Choice("a", "b", "c"))], torch.Generator().manual_seed(0)
    adversary = Adversary(draws, AdversaryConfig(), generator, program_parameters=((), (), ()))
    proposals = adversary.propose(64)
    assert len(np.unique(adversary.theta(proposals)[:, 0])) == 3
    assert not proposals.log_prob.any()  # as likely as the mixture draws each
    assert adversary.learn(proposals, (proposals.raw[:, 0] == 1).astype(float))["grad_norm"] > 0


@pytest.mark.slow
def test_programs_without_columns_are_replayed_although_they_never_fill_a_buffer():
    env = Mixture([Choice(8), Choice(8)], ["one", "other"])
    method = RobustPLR(env, PPO, PLRConfig(buffer=BufferConfig(capacity=64)))
    replayed = [method.update()["levels/replayed"] for _ in range(4)]
    assert len(method.buffer) == 2 and replayed[-1] > 0
    assert 0.2 < method.learner.rollout.train.float().mean() < 0.8


class Pair:
    """A family of a single level."""

    size = 2

    def sample(self, rng):
        return (0.5, 0.5)

    mutate = staticmethod(lambda level, rng: level)
    encode, decode = staticmethod(np.array), staticmethod(tuple)


def test_families_are_refused():
    member = GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), lambda env, level: None, Pair(), 2)
    with pytest.raises(ValueError, match="cart has levels of Pair; a mixture needs vectors"):
        Mixture([member], ["cart"])


def test_columns_that_a_program_ignores_make_no_other_level():
    env = Mixture([Choice(4), Landscape(4)], ["none", "two"])
    levels = env.make_levels([[-0.5, 0.3, 0.1], [-0.5, -0.2, 0.7], [0.5, 0.3, 0.1]])
    assert env.key_of(levels[0])[:4] == env.key_of(levels[1])[:4] and (levels["theta"][0] == levels["theta"][1]).all()
    assert levels["theta"][2].tolist() == [0.5, 0.3, 0.1]


def test_an_edit_to_another_program_draws_its_columns():
    env = Mixture([Choice(4), Landscape(4)], ["none", "two"])
    before = env.make_levels([[-0.5, 0.0, 0.0]] * 200)["theta"]
    after = env.edit_theta(before, 1, 0.1, np.random.default_rng(0))
    assert (env.program_of(after) == 1).all() and after[:, 1:].std() > 0.4


def test_an_adversary_chooses_among_many_values_and_few_in_one_column():
    many, few = Column("k", kinds.Choice(*range(70))), Column("k", kinds.Choice("x", "y", "z"))
    draws = [Column("program", kinds.Choice("many", "few")), Column("1", kinds.Range(-1, 1))]
    adversary = Adversary(
        draws, AdversaryConfig(), torch.Generator().manual_seed(0), program_parameters=((many,), (few,))
    )
    proposals = adversary.propose(400)
    assert proposals.raw[:, 1].max() > 60
    losses = adversary.learn(proposals, (proposals.raw[:, 0] == 1).astype(float))
    assert all(map(np.isfinite, losses.values())) and losses["grad_norm"] > 0
