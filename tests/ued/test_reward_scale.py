"""Reward normalization is Gymnasium's, and no table, score or regret knows of it."""

import dataclasses

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from tests.ued.test_methods import PPO, frontier, numbers
from ued import DR, PLR, BufferConfig, Paired, PairedLiteral, PLRConfig, RobustPLR
from ued.core import checkpoint
from ued.learning import worker
from ued.learning.reward_scale import LIMIT, RewardScale
from ued.learning.rollout import Rollout

NORMED = dataclasses.replace(PPO, norm_reward=True)
GAMMA = 0.9


class Paying(gymnasium.Env):
    """Pays 100 times its own number, give or take a little, and ends at random."""

    observation_space = gymnasium.spaces.Box(0, 1, (1,), np.float32)
    action_space = gymnasium.spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(1, np.float32), {}

    def step(self, action):
        luck = self.np_random.random(3)
        return np.zeros(1, np.float32), 100.0 * luck[0] - 30.0, bool(luck[1] < 0.2), bool(luck[2] < 0.1), {}


def played(num_steps, num_envs):
    """Return rewards and ends of `[T, N]` steps, and what Gymnasium's wrapper makes of the rewards."""
    env = SyncVectorEnv([Paying] * num_envs, autoreset_mode=AutoresetMode.SAME_STEP)
    env.metadata = {**env.metadata, "autoreset_mode": AutoresetMode.SAME_STEP}
    raw = []

    class Noting(gymnasium.vector.VectorWrapper):
        def step(self, actions):
            step = self.env.step(actions)
            raw.append(step[1:4])
            return step

    normed = gymnasium.wrappers.vector.NormalizeReward(Noting(env), gamma=GAMMA)
    if not hasattr(normed, "_autoreset_mode"):
        pytest.skip("this version of Gymnasium carries returns over the ends of episodes")
    normed.reset(seed=0)
    scaled = np.array([normed.step(np.zeros(num_envs, int))[1] for _ in range(num_steps)])
    return *(np.array(column) for column in zip(*raw, strict=True)), scaled


def rollout_of(reward, terminated, truncated, train=None):
    rollout = Rollout.empty(*reward.shape[:2], Paying.observation_space, Paying.action_space)
    rollout.reward = torch.tensor(reward, dtype=torch.float32)
    rollout.terminated, rollout.truncated = torch.tensor(terminated), torch.tensor(truncated)
    rollout.train = torch.ones(reward.shape[:2], dtype=torch.bool) if train is None else torch.tensor(train)
    return rollout


def test_it_is_gymnasiums_over_several_rollouts():
    reward, terminated, truncated, scaled = played(60, 5)
    ours = RewardScale((5,), GAMMA)
    parts = [
        ours.normalize(rollout_of(reward[at : at + 20], terminated[at : at + 20], truncated[at : at + 20])).reward
        for at in (0, 20, 40)
    ]
    np.testing.assert_allclose(torch.cat(parts).numpy(), np.clip(scaled, -LIMIT, LIMIT), rtol=2e-5)
    assert np.ptp(scaled) > 1 and terminated.any() and truncated.any()


def test_rewards_are_limited_at_first():
    rare = np.zeros((40, 4))
    rare[-1, 0] = 1.0
    none = np.zeros((40, 4), bool)
    assert RewardScale((4,), GAMMA).normalize(rollout_of(rare, none, none)).reward.max() == LIMIT


def test_steps_that_are_only_evaluated_do_not_count():
    reward, none = np.random.default_rng(0).normal(size=(30, 6)), np.zeros((30, 6), bool)
    train = np.ones((30, 6), bool)
    train[:, 3:] = False
    reward[:, 3:] *= 1000
    some, few = RewardScale((6,), GAMMA), RewardScale((3,), GAMMA)
    some.normalize(rollout_of(reward, none, none, train))
    few.normalize(rollout_of(reward[:, :3], none[:, :3], none[:, :3]))
    assert some.scale == pytest.approx(few.scale) and some.scale < 10


def test_opponents_share_a_scale():
    ours = RewardScale((2, 2), GAMMA)
    rollout = rollout_of(np.ones((3, 2)), np.zeros((3, 2), bool), np.zeros((3, 2), bool))
    rollout.reward = torch.tensor([[[1.0, -1.0]] * 2] * 3)
    assert ours.normalize(rollout).reward.shape == (3, 2, 2) and ours.mean == 0.0


class Rich(type(frontier())):
    """The frontier, paid in other units, and for each step."""

    unit, pay = 1000.0, 0.0

    def _advance(self, actions):
        observations, reward, *rest = super()._advance(actions)
        return observations, reward * self.unit + self.pay, *rest


def trained(method, ppo, config=None, updates=4, unit=1000.0, pay=0.0):
    env = Rich(16, longest=8, dim=3)
    env.unit, env.pay = unit, pay
    made = method(env, ppo, config, 0)
    records = []
    for _ in range(updates):
        metrics = made.update()
        records.append(made.last.records)
    return made, np.concatenate(records), metrics


@pytest.mark.slow
def test_what_a_student_learns_does_not_depend_on_the_unit_of_rewards():
    """Up to the epsilon of the variance, and as powers of two: 32 bits round them alike."""
    (one, _, _), (other, _, _) = (trained(DR, NORMED, unit=2.0**power) for power in (3, 12))
    for name, weight in one.student.state_dict().items():
        torch.testing.assert_close(weight, other.student.state_dict()[name], rtol=1e-3, atol=1e-4)
    raw, _, _ = trained(DR, PPO, unit=2.0**12)
    assert not torch.allclose(raw.student.critic.weight, one.student.critic.weight, rtol=1e-3, atol=1e-4)


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize("score", ["max_mc", "positive_value_loss", "mna"])
def test_returns_and_scores_are_in_raw_units(score):
    config = PLRConfig(score=score, buffer=BufferConfig(capacity=32))
    method, records, metrics = trained(PLR, NORMED, config, updates=8)
    assert set(np.unique(records["returns"])) == {0.0, 1000.0}
    assert 1 < metrics["student/reward_scale"] < 1000
    scale = metrics["student/reward_scale"]
    assert method.learner.rollout.value.abs().max() < 10 < scale  # of the critic, in normalized units
    assert np.nanmax(records["negative_advantage" if score == "mna" else "absolute_advantage"]) > 10
    if score != "mna":  # which is of levels that were solved
        assert 10 < method.buffer.slots["score"].max() < 1100  # 1000 - V


def test_scores_of_levels_that_are_only_evaluated_are_those_without_normalization():
    """Before the first training step the divisor is 1, where a limit of 10 would make all levels alike."""
    config = PLRConfig(score="positive_value_loss")
    one, other = (trained(RobustPLR, ppo, config, updates=1, pay=100.0)[1] for ppo in (NORMED, PPO))
    for name in ("mean_value", "positive_advantage", "absolute_advantage"):
        np.testing.assert_allclose(one[name], other[name], rtol=1e-6)
    assert np.nanmax(one["positive_advantage"]) > 100


@pytest.mark.slow
def test_regret_is_in_raw_units():
    _, records, _ = trained(Paired, NORMED)
    assert set(np.unique(records["score"] % 125)) <= {0.0}  # of returns of 0 and 1000, two students, two episodes
    assert records["score"].max() > 100


@pytest.mark.slow
def test_it_resumes_bit_for_bit(tmp_path):
    method, _, _ = trained(PLR, NORMED, updates=3)
    checkpoint.save(tmp_path / "c.pt", method.state_dict())
    resumed, _, _ = trained(PLR, NORMED, updates=1)
    resumed.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    for _ in range(3):
        one, other = numbers(method.update()), numbers(resumed.update())
        np.testing.assert_array_equal(list(one.values()), list(other.values()))


def test_compiled_rollouts_are_normalized_as_those_of_torch(monkeypatch):
    from regista.envs.maze.env import Mazes

    scales = []
    for compiled in (True, False):
        monkeypatch.setattr(worker, "COMPILED", compiled)
        method = DR(Mazes(8), dataclasses.replace(NORMED, num_steps=16), None, 0)
        assert method.learner.worker.is_compiled == compiled
        for _ in range(2):
            method.update()
        scales.append((method.learner.rewards.scale, method.learner.rewards.count))
    assert scales[0] == scales[1] and scales[0][1] > 200


def test_students_that_learn_from_regret_refuse_it():
    with pytest.raises(
        ValueError, match=r"students learn from regret, not from rewards: use norm_reward=False \(--no-norm-reward"
    ):
        PairedLiteral(frontier(), NORMED)
