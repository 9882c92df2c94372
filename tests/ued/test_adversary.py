"""The adversary on a landscape of regret that stands still: it finds the peak, and it keeps its spread."""

import dataclasses
import math

import numpy as np
import pytest
import torch

from ued.config import AdversaryConfig
from ued.core.parameters import Choice, Column, Integer, Range, numbered, quantize
from ued.core.seeding import torch_generator
from ued.levels import theta_distribution
from ued.levels.adversary import Adversary, RunningScale

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


@pytest.mark.parametrize("distribution", ["program", "tanh_gaussian", "beta"])
def test_proposals_begin_uniform_and_inside(distribution):
    adversary = Adversary(6, AdversaryConfig(distribution=distribution), torch_generator(0))
    proposals = adversary.propose(4000)
    theta = adversary.theta(proposals)
    assert theta.shape == (4000, 6) and theta.dtype == np.float64
    assert np.abs(theta).max() <= 1.0
    assert theta.std(0) == pytest.approx(np.full(6, UNIFORM_STD), abs=0.04)
    quarters = np.stack([np.histogram(column, 4, (-1, 1))[0] for column in theta.T]) / len(theta)
    assert np.abs(quarters - 0.25).max() < 0.06
    assert proposals.log_prob.mean() == pytest.approx(0.0, abs=0.25)


CHOICES = (Column("side", Choice("in the way", "left", "right", weights=(1, 25, 25))), Column("legs", Integer(2, 6)))
MIXED = (Column("x", Range(0, 1)), *CHOICES, Column("mass", Range(0, 1)))


def test_choices_begin_at_the_weights_of_the_program():
    adversary = Adversary(MIXED, AdversaryConfig(), torch_generator(0))
    proposals = adversary.propose(20_000)
    theta = adversary.theta(proposals)
    assert (theta[:, 1:3] == quantize(theta, MIXED)[:, 1:3]).all()
    sides, legs = (np.unique(column, return_counts=True)[1] / len(theta) for column in theta[:, 1:3].T)
    assert sides == pytest.approx(np.array([1, 25, 25]) / 51, abs=0.01)
    assert legs == pytest.approx(np.full(5, 0.2), abs=0.01)
    alone = Adversary(CHOICES, AdversaryConfig(), torch_generator(0)).propose(100)
    assert alone.log_prob == pytest.approx(0.0, abs=1e-6)  # exactly what the program draws


PROGRAMS = ((), numbered("x", 3), (Column("side", Choice("left", "right", weights=(1, 3))), Column("y", Range(0, 1))))
MIXTURE = (Column("program", Choice("a", "b", "c")), *numbered("k", 3))


def test_of_a_mixture_programs_begin_alike_and_unused_columns_stay_at_0():
    adversary = Adversary(MIXTURE, AdversaryConfig(), torch_generator(0), program_parameters=PROGRAMS)
    theta = adversary.theta(adversary.propose(6000))
    program = np.rint((theta[:, 0] + 1) / 2 * 3 - 0.5).astype(int)
    assert theta[:, 0] == pytest.approx((2 * program + 1) / 3 - 1, abs=1e-6)
    assert np.bincount(program) / 6000 == pytest.approx([1 / 3] * 3, abs=0.04)
    assert not theta[program == 0, 1:].any() and not theta[program == 2, 3:].any()
    assert theta[program == 1, 1:].std(0) == pytest.approx(np.full(3, UNIFORM_STD), abs=0.04)
    assert np.unique(theta[program == 2, 1]).tolist() == [-0.75, 0.25]
    assert (theta[program == 2, 1] < 0).mean() == pytest.approx(0.25, abs=0.04)
    assert theta[program == 2, 2].std() == pytest.approx(UNIFORM_STD, abs=0.04)


def moved(draws, program_parameters=(), distribution="program"):
    """Return an adversary whose weights are anything."""
    config = AdversaryConfig(distribution=distribution)
    adversary = Adversary(draws, config, torch_generator(0), program_parameters=program_parameters)
    for weight in adversary.network.parameters():
        weight.data += 0.2 * torch.randn(weight.shape, generator=torch_generator(1))
    return adversary


@pytest.mark.slow
@pytest.mark.parametrize(
    ("draws", "program_parameters"), [(numbered("x", 2), ()), (CHOICES, ()), (MIXED, ()), (MIXTURE, PROGRAMS)]
)
@pytest.mark.long
def test_densities_are_those_of_what_is_drawn(draws, program_parameters):
    """The density of proposals is relative to the program's: under that, its mean is 1, and so is its inverse's."""
    network = moved(draws, program_parameters).network
    first = Adversary(draws, AdversaryConfig(), torch_generator(0), program_parameters=program_parameters).network
    z = torch.full((200_000, 1), 0.7)
    with torch.inference_mode():
        raw, base = first.sample(z, torch_generator(2))
        assert float((network(z, raw)[0] - base).exp().mean()) == pytest.approx(1.0, abs=0.03)
        own, log_prob = network.sample(z, torch_generator(3))
        assert float((first(z, own)[0] - log_prob).exp().mean()) == pytest.approx(1.0, abs=0.1)
        assert float(log_prob.mean()) > 0.01  # the divergence from the program


@pytest.mark.slow
@pytest.mark.parametrize("distribution", ["tanh_gaussian", "beta"])
def test_densities_of_one_hump_are_relative_to_the_uniform(distribution):
    network = moved(2, distribution=distribution).network
    with torch.inference_mode():
        raw, log_prob = network.sample(torch.full((200_000, 1), 0.7), torch_generator(2))
    theta = network.theta(raw.numpy())
    inside = (np.abs(theta - 0.1) < 0.1).all(1)
    density = inside.mean() / 0.1**2  # of the uniform's share
    assert np.exp(log_prob.numpy()[inside]).mean() == pytest.approx(density, rel=0.05)


@pytest.mark.long
def test_of_a_mixture_it_finds_the_program_that_pays_and_where():
    config, rng = AdversaryConfig(), np.random.default_rng(0)
    columns, own = (Column("program", Choice("a", "b", "c")), *numbered("x", 2)), (numbered("x", 2),) * 3
    adversary = Adversary(columns, config, torch_generator(0), program_parameters=own)
    for _ in range(40):
        proposals = adversary.propose(128)
        theta = adversary.theta(proposals)
        metrics = adversary.learn(proposals, (theta[:, 0] > 1 / 3) * landscape(theta[:, 1:], rng))
    theta = adversary.theta(adversary.propose(2000))
    last = theta[:, 0] > 1 / 3
    assert last.mean() > 0.8
    assert np.abs(theta[last, 1:].mean(0) - PEAK).max() < 0.25
    assert math.isfinite(metrics["entropy"])


@pytest.mark.long
def test_without_entropy_the_proposals_collapse():
    runs = [taught(AdversaryConfig(ent_coef=0.0), seed=seed) for seed in range(3)]
    theta, _ = runs[0]
    assert np.abs(theta.mean(0) - PEAK).max() < 0.15
    assert theta.std(0).mean() < 0.16
    entropies = [metrics["entropy"] for _, metrics in runs]
    assert np.median(entropies) < -2.5  # of uniform proposals it is 1.4; rounding decides how far a single run gets


@pytest.mark.long
@pytest.mark.parametrize(
    ("distribution", "ent_coef", "spread", "entropy"),
    [
        ("program", AdversaryConfig().ent_coef, 0.055, -3.2),
        ("tanh_gaussian", 0.06, 0.04, -3.8),
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


@pytest.mark.long
def test_pure_entropy_keeps_them_uniform():
    theta, metrics = taught(AdversaryConfig(ent_coef=1.0), of=lambda theta, rng: rng.normal(size=len(theta)))
    assert theta.std(0) == pytest.approx([UNIFORM_STD, UNIFORM_STD], abs=0.06)
    assert metrics["entropy"] == pytest.approx(2 * math.log(2), abs=0.1)


@pytest.mark.long
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


def test_weights_of_another_distribution_are_refused_in_a_sentence():
    state = Adversary(3, AdversaryConfig(distribution="tanh_gaussian"), torch_generator(0)).state_dict()
    with pytest.raises(
        ValueError, match=r"^the saved adversary has other weights \(.*hump.weight.*'program' over these 3"
    ):
        Adversary(3, AdversaryConfig(), torch_generator(0)).load_state_dict(state)


def test_without_free_parameters_there_is_nothing_to_choose():
    with pytest.raises(ValueError) as error:
        Adversary(0, AdversaryConfig(), torch_generator(0))
    assert str(error.value) == (
        "an adversary has no parameters to choose: theta has 0 columns; use domain randomization, or give the "
        "program a random value"
    )


def test_the_thesis_settings_and_refused_ones():
    config = AdversaryConfig.thesis()
    assert (config.ent_coef, config.update_epochs, config.max_grad_norm, config.learning_rate) == (0.01, 5, 0.5, 8e-5)
    assert config.distribution == "tanh_gaussian" and AdversaryConfig().distribution == "program"
    with pytest.raises(ValueError, match="update_epochs must be at least 1, got 0"):
        dataclasses.replace(config, update_epochs=0)


@pytest.mark.parametrize("distribution", ["program", "tanh_gaussian", "beta"])
def test_no_proposals_are_an_empty_array(distribution):
    adversary = Adversary(MIXED, AdversaryConfig(distribution=distribution), torch_generator(0))
    proposals = adversary.propose(0)
    assert adversary.theta(proposals).shape == (0, 4) and proposals.log_prob.shape == (0,)


WIDE = (Column("cell", Choice(*range(70))), *CHOICES, Column("x", Range(0, 1)), Column("other", Choice(*range(90))))


@pytest.mark.slow
def test_choices_of_many_values_are_padded_apart_and_nothing_else_changes(monkeypatch):
    apart, rng = moved(WIDE).network, torch_generator(3)
    assert apart.logits.shape[:2] == (2, 5) and apart.wide_logits.shape[:2] == (2, 90)
    monkeypatch.setattr(theta_distribution, "WIDE", 1000)
    joined = moved(WIDE).network
    with torch.no_grad():
        for name in ("logits", "seen"):
            both = getattr(joined, name).zero_()
            both[1:3, :5], both[[0, 3]] = getattr(apart, name), getattr(apart, f"wide_{name}")
        for part in ("first", "second", "value", "bumps"):
            getattr(joined, part).load_state_dict(getattr(apart, part).state_dict())
    z = torch.empty(200, 1).normal_(generator=rng)
    raw, density = apart.sample(z, rng)
    assert len(raw[:, 0].unique()) > 20 and density.std() > 0.1
    for mine, theirs in zip(apart(z, raw), joined(z, raw), strict=True):
        torch.testing.assert_close(mine, theirs, rtol=1e-4, atol=1e-4)
