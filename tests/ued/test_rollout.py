"""Advantages against a slow reference, episodes carried over, and exact counts."""

import numpy as np
import pytest
import torch
from probes import Endless, TwoStep

from ued.config import PPOConfig
from ued.core.seeding import torch_generator
from ued.learning.rollout import Rollout, gae, negative_advantages
from ued.learning.student import Student
from ued.learning.worker import RolloutWorker, collect
from ued.levels.record import level_record_dtype, make_records


def random_rollout(steps=40, envs=6, seed=0):
    stream = torch_generator(seed)
    terminated = torch.rand(steps, envs, generator=stream) < 0.1
    truncated = torch.rand(steps, envs, generator=stream) < 0.1
    numbers = [torch.randn(steps, envs, generator=stream) for _ in range(3)]
    final = torch.randn(steps, envs, generator=stream)
    last = torch.randn(envs, generator=stream)
    empty = torch.zeros(steps, envs)
    learned = torch.ones_like(terminated)
    return Rollout(
        empty,
        empty,
        numbers[0],
        numbers[1],
        numbers[2],
        terminated,
        truncated,
        final,
        learned,
        last,
        torch.zeros(envs, 0),
    )


def slow_gae(rollout, gamma, gae_lambda):
    """Sum, as defined, discounted temporal-difference errors to the end of the episode or the rollout."""
    steps, envs = rollout.reward.shape
    advantage = torch.zeros(steps, envs)
    for n in range(envs):
        for t in range(steps):
            weight = 1.0
            for k in range(t, steps):
                if rollout.terminated[k, n]:
                    following = 0.0
                elif rollout.truncated[k, n]:
                    following = rollout.final_value[k, n]
                else:
                    following = rollout.value[k + 1, n] if k + 1 < steps else rollout.last_value[n]
                advantage[t, n] += weight * (rollout.reward[k, n] + gamma * following - rollout.value[k, n])
                weight *= gamma * gae_lambda
                if rollout.terminated[k, n] or rollout.truncated[k, n]:
                    break
    return advantage


@pytest.mark.parametrize(("gamma", "gae_lambda"), [(0.9, 0.8), (1.0, 1.0), (0.99, 0.0), (0.0, 0.5)])
def test_gae_agrees_with_its_definition(gamma, gae_lambda):
    rollout = random_rollout()
    torch.testing.assert_close(gae(rollout, gamma, gae_lambda), slow_gae(rollout, gamma, gae_lambda))


def slow_negative(rollout, gamma, gae_lambda):
    """Sum, as defined, the weighted losses after n steps, relative to the highest value so far."""
    steps, envs = rollout.reward.shape
    advantage = torch.zeros(steps, envs)
    error = gae(rollout, gamma, 0.0)  # of the value after one step
    for n in range(envs):
        for t in range(steps):
            estimates, losses = [0.0], []  # relative to the first value
            for k in range(t, steps):
                estimates.append(estimates[-1] + gamma ** (k - t) * float(error[k, n]))
                losses.append(estimates[-1] - max(estimates))
                if rollout.terminated[k, n] or rollout.truncated[k, n]:
                    break
            weights = [(1 - gae_lambda) * gae_lambda**i for i in range(len(losses))]
            weights[-1] = gae_lambda ** (len(losses) - 1)  # the last one stands for all that would follow
            advantage[t, n] = sum(weight * loss for weight, loss in zip(weights, losses, strict=True))
    return advantage


@pytest.mark.parametrize(("gamma", "gae_lambda"), [(0.9, 0.8), (1.0, 1.0), (0.99, 0.0)])
def test_negative_advantages_agree_with_their_definition(gamma, gae_lambda):
    rollout = random_rollout()
    found = negative_advantages(rollout, gamma, gae_lambda)
    torch.testing.assert_close(found, slow_negative(rollout, gamma, gae_lambda), atol=1e-5, rtol=1e-5)
    assert (found <= 0).all() and (found < 0).any()


def test_what_is_lost_after_a_gain_counts():
    """The values 0, 1, 0 end in nothing: GAE sees no loss at the first step, MNA that of the value 1."""
    rollout = random_rollout()
    rollout.reward[:], rollout.value[:], rollout.last_value[:] = 0.0, 0.0, 0.0
    rollout.terminated[:], rollout.truncated[:] = False, False
    rollout.value[1], rollout.terminated[2] = 1.0, True
    assert gae(rollout, 1.0, 1.0)[:3, 0].tolist() == [0.0, -1.0, 0.0]
    assert negative_advantages(rollout, 1.0, 1.0)[:3, 0].tolist() == [-1.0, -1.0, 0.0]


def test_with_lambda_one_advantage_plus_value_is_the_return():
    rollout = random_rollout(seed=1)
    rollout.terminated[-1] = True  # so that no value of a network enters
    rollout.truncated[:] = False
    target = gae(rollout, 1.0, 1.0) + rollout.value
    for n in range(6):
        end = int(rollout.terminated[:, n].nonzero()[0])
        assert target[0, n] == pytest.approx(float(rollout.reward[: end + 1, n].sum()), abs=1e-4)


def records_of(levels):
    return make_records(level_record_dtype(levels.dtype), levels)


def worker(env, num_steps=8, on_episode_end=lambda ended, returns, success: (ended[:0], None)):
    spaces = env.single_observation_space, env.single_action_space
    student = Student(*spaces, PPOConfig(hidden_size=8), torch_generator(0))
    made = RolloutWorker(student, env, num_steps, torch_generator(1), on_episode_end)
    env.reset(seed=0)
    made.start(records_of(env.sample_levels(env.num_envs)))
    return made


def test_episodes_run_on_from_one_rollout_to_the_next():
    playing = worker(TwoStep(4), num_steps=3)
    found = []
    for _ in range(4):  # 12 steps, 6 episodes of 2 steps in each of 4 environments
        collect([playing])
        found.append(playing.pop_episodes())
    assert [len(episodes.returns) for episodes in found] == [4, 8, 4, 8]
    assert all((episodes.returns == 1).all() and (episodes.lengths == 2).all() for episodes in found)
    assert playing.env_steps == 48


def test_only_what_was_cut_off_is_valued():
    playing = worker(Endless(3), num_steps=7)
    torch.nn.init.constant_(playing.student.critic.bias, 2.5)
    collect([playing])
    rollout = playing.rollout
    expected = torch.tensor(2.5)
    assert rollout.truncated[4].all() and int(rollout.truncated.sum()) == 3
    assert torch.equal(rollout.final_value[4], expected.expand(3))
    assert int((rollout.final_value != 0).sum()) == 3
    assert torch.equal(rollout.last_value, expected.expand(3))


def test_terminated_and_truncated_at_once_is_terminated():
    rollout = random_rollout()
    rollout.terminated[:], rollout.truncated[:] = True, True
    rollout.final_value[:] = 100.0
    torch.testing.assert_close(gae(rollout, 0.9, 0.9), rollout.reward - rollout.value)


def test_a_new_level_comes_to_the_environments_that_are_named():
    def every_second(ended, returns, success):
        envs = ended[ended % 2 == 1][::-1]  # in any order
        levels = env.make_levels(np.zeros((len(envs), 0)))
        levels["seed"] = envs + 100
        return envs, records_of(levels)

    env = TwoStep(4)
    playing = worker(env, num_steps=2, on_episode_end=every_second)
    collect([playing])
    assert env.levels["seed"][1::2].tolist() == [101, 103] and (env.levels["seed"][::2] > 103).all()
