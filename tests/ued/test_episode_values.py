"""What the critic thought during an episode, against a slow sum, over rollouts that cut episodes anywhere."""

import numpy as np
import pytest
import torch

from ued.learning.rollout import Rollout
from ued.learning.value_stats import NAMES, EpisodeValues


def rollout(rng, steps, envs, rate):
    numbers = [torch.as_tensor(rng.normal(size=(steps, envs)), dtype=torch.float32) for _ in range(2)]
    terminated, truncated = (torch.as_tensor(rng.random((steps, envs)) < rate) for _ in range(2))
    empty, end = torch.zeros(steps, envs), (torch.zeros(envs), torch.zeros(envs, 0))
    learned = torch.ones(steps, envs, dtype=torch.bool)
    return Rollout(empty, empty, empty, numbers[0], empty, terminated, truncated, empty, learned, *end), numbers[1]


@pytest.mark.parametrize("rate", [0.0, 0.02, 0.2, 0.9])
def test_means_over_the_steps_of_each_episode(rate):
    rng = np.random.default_rng(0)
    values, open_, resumed = EpisodeValues(5), [[] for _ in range(5)], EpisodeValues(5)
    for _ in range(6):
        made, advantage = rollout(rng, 16, 5, rate)
        found = values.track(made, advantage)
        resumed.load_state_dict(values.state_dict())
        expected = []
        for t in range(16):
            for n in range(5):
                v, a = float(made.value[t, n]), float(advantage[t, n])
                open_[n].append((v, max(a, 0.0), abs(a)))
                if made.terminated[t, n] or made.truncated[t, n]:
                    expected.append(np.mean(open_[n], 0))
                    open_[n] = []
        columns = np.array(expected).reshape(-1, 3).T
        for name, column in zip(NAMES, columns, strict=True):
            assert found[name] == pytest.approx(column, abs=1e-6)
    assert (resumed.sums == values.sums).all() and (resumed.steps == values.steps).all()


def test_the_sum_of_negative_advantages_of_each_episode():
    rng = np.random.default_rng(2)
    values, sums, open_ = EpisodeValues(3, negative=True), [], np.zeros(3)
    for _ in range(4):
        made, advantage = rollout(rng, 8, 3, 0.1)
        found = values.track(made, advantage, -advantage.abs())
        sums.clear()
        for t in range(8):
            open_ += advantage[t].abs().numpy()
            ended = (made.terminated | made.truncated)[t].numpy()
            sums.extend(open_[ended])
            open_[ended] = 0.0
        assert found["negative_advantage"] == pytest.approx(np.array(sums), abs=1e-5)
        assert set(found) == {*NAMES, "negative_advantage"}


def test_what_was_cut_off_is_forgotten():
    rng = np.random.default_rng(1)
    values = EpisodeValues(3)
    values.track(*rollout(rng, 8, 3, 0.0))
    values.reset()
    fresh = EpisodeValues(3)
    made = rollout(rng, 8, 3, 0.3)
    assert all((a == b).all() for a, b in zip(values.track(*made).values(), fresh.track(*made).values(), strict=True))
