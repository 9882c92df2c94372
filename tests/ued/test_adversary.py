"""The adversary on a landscape of regret that stands still: it finds the peak, and it keeps its spread."""

import copy
import dataclasses
import math

import numpy as np
import pytest
import torch

from ued.config import AdversaryConfig
from ued.levels.adversary import Adversary, Autograd, Beta, Composed, RunningScale, Squashed, WrittenOut
from ued.seeding import torch_generator

PEAK = 0.5
UNIFORM_STD = 1 / math.sqrt(3)


def landscape(theta, rng, noise=0.5):
    """Return a bump of height 1 and width 0.4 at (0.5, 0.5), under noise as of a few episodes."""
    height = np.exp(-((theta - PEAK) ** 2).sum(1) / (2 * 0.4**2))
    return height + noise * rng.normal(size=len(theta))


def taught(config, updates=80, seed=0, of=landscape):
    adversary, rng = Adversary(2, config, torch_generator(seed)), np.random.default_rng(seed)
    for _ in range(updates):
        proposals = adversary.propose(128)
        metrics = adversary.learn(proposals, of(adversary.theta(proposals), rng))
    return adversary.theta(adversary.propose(2000)), metrics


@pytest.mark.parametrize("distribution", ["squashed", "beta"])
def test_proposals_begin_uniform_and_inside(distribution):
    adversary = Adversary(6, AdversaryConfig(distribution=distribution), torch_generator(0))
    theta = adversary.theta(adversary.propose(4000))
    assert theta.shape == (4000, 6) and theta.dtype == np.float64
    assert np.abs(theta).max() <= 1.0
    assert theta.std(0) == pytest.approx(np.full(6, UNIFORM_STD), abs=0.04)
    quarters = np.stack([np.histogram(column, 4, (-1, 1))[0] for column in theta.T]) / len(theta)
    assert np.abs(quarters - 0.25).max() < 0.06


@pytest.mark.parametrize("distribution", ["squashed", "beta"])
def test_of_a_mixture_programs_begin_alike_and_unused_columns_stay_at_0(distribution):
    config = AdversaryConfig(distribution=distribution)
    adversary = Adversary(4, config, torch_generator(0), program_dims=(0, 3, 1))
    theta = adversary.theta(adversary.propose(6000))
    program = np.rint((theta[:, 0] + 1) / 2 * 3 - 0.5).astype(int)
    assert theta[:, 0] == pytest.approx((2 * program + 1) / 3 - 1, abs=1e-6)
    assert np.bincount(program) / 6000 == pytest.approx([1 / 3] * 3, abs=0.04)
    assert not theta[program == 0, 1:].any() and not theta[program == 2, 2:].any()
    assert theta[program == 1, 1:].std(0) == pytest.approx(np.full(3, UNIFORM_STD), abs=0.04)
    assert theta[program == 2, 1].std() == pytest.approx(UNIFORM_STD, abs=0.04)


def test_of_a_mixture_densities_and_entropy_are_those_of_choice_and_part():
    logits = torch.log(torch.tensor([[0.2, 0.8]]))
    parts = [Squashed(torch.zeros(1, d), torch.zeros(1, d)) for d in (1, 2)]
    policy, raw = Composed(logits, parts, 3), torch.tensor([[-0.5, 0.3, 0.0], [0.5, 0.3, -0.7]])
    own = [parts[0].log_prob(raw[:1, 1:2]).item(), parts[1].log_prob(raw[1:, 1:3]).item()]
    expected = [math.log(0.2) + own[0], math.log(0.8) + own[1]]
    assert policy.log_prob(raw).tolist() == pytest.approx(expected, abs=1e-5)
    uniform = [Beta(torch.full((1, d), -4.0), torch.full((1, d), -4.0)) for d in (1, 2)]
    entropy = Composed(logits, uniform, 3).theta_entropy(torch_generator(0)).item()
    chosen = -0.2 * math.log(0.2) - 0.8 * math.log(0.8)
    assert entropy == pytest.approx(chosen + 0.2 * math.log(2) + 0.8 * 2 * math.log(2), abs=1e-3)


@pytest.mark.slow
def test_of_a_mixture_it_finds_the_program_that_pays_and_where():
    config, rng = AdversaryConfig(), np.random.default_rng(0)
    adversary = Adversary(3, config, torch_generator(0), program_dims=(2, 2, 2))
    for _ in range(40):
        proposals = adversary.propose(128)
        theta = adversary.theta(proposals)
        metrics = adversary.learn(proposals, (theta[:, 0] > 1 / 3) * landscape(theta[:, 1:], rng))
    theta = adversary.theta(adversary.propose(2000))
    last = theta[:, 0] > 1 / 3
    assert last.mean() > 0.8
    assert np.abs(theta[last, 1:].mean(0) - PEAK).max() < 0.25
    assert math.isfinite(metrics["entropy"])


@pytest.mark.slow
def test_without_entropy_the_proposals_collapse():
    theta, metrics = taught(AdversaryConfig(ent_coef=0.0))
    assert np.abs(theta.mean(0) - PEAK).max() < 0.15
    assert theta.std(0).mean() < 0.16
    assert metrics["entropy"] < -3  # one vector z means one level


@pytest.mark.slow
@pytest.mark.parametrize(
    ("distribution", "ent_coef", "spread", "entropy"),
    [
        ("squashed", AdversaryConfig().ent_coef, 0.055, -3.2),
        ("beta", 0.06, 0.07, -2.6),
    ],
)
def test_with_an_entropy_bonus_they_keep_their_spread_and_still_move(distribution, ent_coef, spread, entropy):
    theta, metrics = taught(AdversaryConfig(distribution=distribution, ent_coef=ent_coef))
    assert theta.std(0).mean() > spread
    assert metrics["entropy"] > entropy
    assert np.abs(theta.mean(0) - PEAK).max() < 0.25
    assert landscape(theta, np.random.default_rng(0), noise=0).mean() > 0.7  # uniform proposals reach 0.23
    assert (np.abs(theta) > 0.95).mean() < 0.05  # and do not flee into the corners


@pytest.mark.slow
def test_pure_entropy_keeps_them_uniform():
    theta, metrics = taught(AdversaryConfig(ent_coef=1.0), of=lambda theta, rng: rng.normal(size=len(theta)))
    assert theta.std(0) == pytest.approx([UNIFORM_STD, UNIFORM_STD], abs=0.06)
    assert metrics["entropy"] == pytest.approx(2 * math.log(2), abs=0.1)


def test_entropy_is_measured_in_the_space_of_theta():
    """Against the density of θ itself, by the change of variables."""
    policy = Squashed(torch.tensor([[0.3, -1.0]]).expand(200_000, 2), torch.tensor([[-0.5, 0.2]]).expand(200_000, 2))
    raw = policy.sample(torch_generator(1))
    log_density = policy.log_prob(raw) - torch.log1p(-(torch.tanh(raw.double()) ** 2)).sum(-1)
    assert float(policy.theta_entropy(torch_generator(0)).mean()) == pytest.approx(-float(log_density.mean()), abs=0.01)
    beta = Beta(torch.full((200_000, 2), 1.0), torch.full((200_000, 2), 1.5))
    estimate = -beta.log_prob(beta.sample(torch_generator(2))).mean()
    assert float(beta.theta_entropy(torch_generator(0)).mean()) == pytest.approx(float(estimate), abs=0.01)


@pytest.mark.parametrize("distribution", ["squashed", "beta"])
@pytest.mark.parametrize(("columns", "program_dims"), [(6, ()), (np.array([0, 3, 0, 5]), ()), (4, (0, 3, 1))])
def test_gradients_are_those_of_the_loss(distribution, columns, program_dims):
    """Against autograd, for a policy that has moved, so that ratios are clipped, and whose deviations are."""
    config = AdversaryConfig(distribution=distribution, update_epochs=1, max_grad_norm=1e12, ent_coef=0.3)
    adversary = Adversary(columns, config, torch_generator(0), program_dims=program_dims)
    proposals = adversary.propose(64)
    for weight in adversary.network.parameters():
        weight.data += 0.3 * torch.randn(weight.shape, generator=torch_generator(1))
    reference, generator = copy.deepcopy((adversary.network, adversary.generator))
    regret = np.random.default_rng(0).normal(size=64)
    losses = adversary.learn(proposals, regret)
    z, raw, log_prob = map(torch.as_tensor, proposals)
    policy, value = reference(z)
    target = torch.as_tensor(adversary.scale(regret), dtype=torch.float32)
    ratio, advantage = (policy.log_prob(raw) - log_prob).clamp(-20, 20).exp(), (target - value).detach()
    gain = torch.min(ratio * advantage, ratio.clamp(1 - config.clip_coef, 1 + config.clip_coef) * advantage).mean()
    error, entropy = 0.5 * (target - value).square().mean(), policy.theta_entropy(generator).mean()
    (-gain - config.ent_coef * entropy + config.vf_coef * error).backward()
    for ours, theirs in zip(adversary.network.parameters(), reference.parameters(), strict=True):
        torch.testing.assert_close(ours.grad, theirs.grad, rtol=1e-3, atol=1e-5)
    wanted = [-gain, error, entropy, torch.cat([weight.grad.flatten() for weight in reference.parameters()]).norm()]
    assert list(losses.values()) == pytest.approx([value.item() for value in wanted], rel=1e-4, abs=1e-5)
    assert ((ratio - 1).abs() > config.clip_coef).float().mean() > 0.05


def test_proposals_by_hand_are_those_of_torch():
    network = Adversary(3, AdversaryConfig(context_size=5), torch_generator(0)).network
    for weight in network.parameters():
        weight.data += 0.3 * torch.randn(weight.shape, generator=torch_generator(1))
    z = np.random.default_rng(0).standard_normal((64, 5), np.float32)
    (raw, log_prob), theirs = (way(network, torch_generator(2), z).sample() for way in (WrittenOut, Autograd))
    assert raw.dtype == log_prob.dtype == np.float32 and raw.flags.c_contiguous
    assert raw == pytest.approx(theirs[0], abs=1e-5) and log_prob == pytest.approx(theirs[1], abs=1e-4)


@pytest.mark.slow
def test_learning_does_not_depend_on_the_unit_of_regret():
    one, _ = taught(AdversaryConfig(), updates=40)
    other, _ = taught(AdversaryConfig(), updates=40, of=lambda theta, rng: 1000 * landscape(theta, rng) - 300)
    assert np.abs(one.mean(0) - other.mean(0)).max() < 0.1


def test_the_scale_follows_what_it_sees():
    scale = RunningScale()
    scale.track(np.array([4.0, 6.0]))
    assert scale(np.array([4.0, 6.0])) == pytest.approx([-1, 1], abs=0.01)
    for _ in range(60):
        scale.track(np.array([0.0, 0.0]))
    assert scale(np.array([0.0])) == pytest.approx([0.0], abs=0.1)


def test_it_resumes_to_the_same_numbers():
    config, rng = AdversaryConfig(context_size=4), np.random.default_rng(0)
    one, two = Adversary(3, config, torch_generator(0)), Adversary(3, config, torch_generator(9))
    proposals = one.propose(64)
    one.learn(proposals, rng.normal(size=64))
    two.load_state_dict(one.state_dict())
    regret = rng.normal(size=64)
    first, second = (adversary.learn(adversary.propose(64), regret) for adversary in (one, two))
    assert first == second


def test_without_free_parameters_there_is_nothing_to_choose():
    with pytest.raises(ValueError) as error:
        Adversary(0, AdversaryConfig(), torch_generator(0))
    assert str(error.value) == (
        "there is nothing for an adversary to choose: the environment has no free parameters (theta has 0 columns); "
        "use domain randomisation, or give the program a random value"
    )


def test_the_thesis_settings_and_refused_ones():
    config = AdversaryConfig.thesis()
    assert (config.ent_coef, config.update_epochs, config.max_grad_norm, config.learning_rate) == (0.01, 5, 0.5, 8e-5)
    with pytest.raises(ValueError, match="update_epochs must be at least 1, got 0"):
        dataclasses.replace(config, update_epochs=0)
