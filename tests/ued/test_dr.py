"""Domain randomization: where levels come from, and when they change."""

import numpy as np
import pytest
from probes import Choice, HalfValid, Landscape

from ued.config import DRConfig, PPOConfig
from ued.methods.dr import DR

PPO = PPOConfig(num_steps=16, num_minibatches=1, update_epochs=1, hidden_size=8)


@pytest.mark.slow
def test_a_level_for_every_episode_drawn_evenly():
    method = DR(HalfValid(64), PPO, seed=0)
    theta = np.concatenate([(method.update(), method.last.theta)[1] for _ in range(10)])
    assert len(np.unique(theta, axis=0)) == len(theta) > 3000
    assert (theta[:, 0] > 0).all()
    assert theta[:, 1].std() == pytest.approx(1 / np.sqrt(3), abs=0.02)


def test_a_level_for_every_rollout():
    env = Landscape(8)
    method = DR(env, PPO, DRConfig(resample_level_every="rollout"), seed=0)
    for _ in range(3):
        method.update()
        theta = method.last.theta
        assert len(np.unique(theta, axis=0)) == len(theta) == 8


def test_it_needs_no_free_parameters():
    assert DR(Choice(8), PPO).update()["episodes/student"] == 8 * 16


def test_what_the_last_update_saw():
    method = DR(Landscape(8), PPO, seed=0)
    assert method.last is None
    metrics = method.update()
    batch = method.last
    assert metrics["episodes/student"] == len(batch.theta)
    assert metrics["return/student"] == pytest.approx(batch.returns["student"].mean())
    assert (batch.episodes["student"] == 1).all() and np.isnan(batch.score).all()
    assert method.env_steps == 8 * 16 and method.updates == 1


def test_no_finished_episode_is_no_return():
    class Long(Landscape):
        def outcome(self, actions):
            never = np.zeros(self.num_envs, bool)
            return np.zeros(self.num_envs), never, never

    metrics = DR(Long(4), PPO).update()
    assert metrics["episodes/student"] == 0 and np.isnan(metrics["return/student"])


def test_another_kind_of_domain_randomization_is_refused():
    with pytest.raises(ValueError, match="resample_level_every must be episode or rollout, got 'step'"):
        DRConfig(resample_level_every="step")
