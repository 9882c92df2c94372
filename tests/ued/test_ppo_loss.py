"""The closed form of PPO's loss has the numbers and the gradient that autograd finds for its formula."""

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete, MultiDiscrete
from probes import Follow
from torch import Tensor

from ued.config import PPOConfig
from ued.core.seeding import torch_generator
from ued.learning import backprop
from ued.learning.backprop import by_hand, has_tanh_layers
from ued.learning.kl import KLRegularizer
from ued.learning.memory import Past
from ued.learning.minibatches import Batch, normalize
from ued.learning.networks import Categorical, MultiCategorical
from ued.learning.ppo_loss import Losses, approx_kl, categorical_losses, losses, means
from ued.learning.student import Student
from ued.methods.dr import DR

ROWS = 64
SHAPES = [((), None), ((3,), None), ((), [4, 4]), ((), [2, 5, 3]), ((3,), [4, 2])]  # agents, choices
EXACT = {torch.float32: 1e-6, torch.float64: 1e-12}


def minibatch(agents: tuple, choices: list[int] | None, kind: torch.dtype) -> tuple[Tensor, Tensor, Batch]:
    """Return logits, values and old steps whose ratios and values lie on both sides of the clipping range."""
    draw, shape = torch_generator(1), (ROWS, *agents)
    logits = torch.randn(*shape, sum(choices or [5]), generator=draw, dtype=kind)
    highest = torch.tensor(choices or [5])
    action = (torch.rand(*shape, len(highest), generator=draw) * highest).long()
    action = action if choices else action[..., 0]
    numbers = torch.randn(4, *shape, generator=draw, dtype=kind)
    moved = 0.5 * torch.randn(shape, generator=draw, dtype=kind)
    value = numbers[1] + moved
    numbers[0] = policy_of(logits, choices).log_prob(action) + 0.3 * numbers[0]
    nothing = torch.zeros(ROWS, 0)
    return logits.requires_grad_(), value.requires_grad_(), Batch(Past(nothing), nothing, None, None, action, numbers)


def policy_of(logits: Tensor, choices: list[int] | None) -> Categorical:
    return MultiCategorical(logits, np.array(choices)) if choices else Categorical(logits)


@pytest.mark.parametrize(("agents", "choices"), SHAPES)
@pytest.mark.parametrize("kind", EXACT)
@pytest.mark.parametrize("clip_vloss", [False, True])
def test_losses_and_gradients_are_those_of_the_formula(agents, choices, kind, clip_vloss):
    config = PPOConfig(clip_vloss=clip_vloss, ent_coef=0.05, vf_coef=0.7, clip_coef=0.25)
    logits, value, old = minibatch(agents, choices, kind)
    policy = policy_of(logits, choices)
    parts, by_logits, by_value = categorical_losses(policy.logits, value, old, config)
    wanted = losses(policy, value, old, config)
    for ours, theirs in zip(parts, wanted, strict=True):
        torch.testing.assert_close(ours, theirs.detach(), atol=EXACT[kind], rtol=EXACT[kind])
    expected = torch.autograd.grad(wanted.total(config), [policy.logits, value])
    for ours, theirs in zip((by_logits, by_value), expected, strict=True):
        torch.testing.assert_close(ours, theirs, atol=EXACT[kind], rtol=EXACT[kind])
    ratio = wanted.log_ratio.exp()
    assert ((ratio - 1).abs() > 0.25).any() and ((ratio - 1).abs() < 0.25).any()
    assert ((value - old.value).abs() > 0.25).any() and by_value.eq(0).any() == clip_vloss


def test_the_gradient_is_that_of_differences():
    config = PPOConfig(ent_coef=0.05)
    logits, value, old = minibatch((), [3, 2], torch.float64)
    _, by_logits, by_value = categorical_losses(policy_of(logits, [3, 2]).logits, value, old, config)

    def total(logits: Tensor, value: Tensor) -> float:
        return losses(policy_of(logits, [3, 2]), value, old, config).total(config).item()

    logits, value = logits.detach(), value.detach()
    for row in range(4):
        step = torch.zeros_like(value)
        step[row] = 1e-6
        assert (total(logits, value + step) - total(logits, value - step)) / 2e-6 == pytest.approx(
            by_value[row].item(), abs=1e-8
        )
        nudge = torch.zeros_like(logits)
        nudge[row, 1] = 1e-6
        assert (total(logits + nudge, value) - total(logits - nudge, value)) / 2e-6 == pytest.approx(
            by_logits[row, 0, 1].item(), abs=1e-8
        )


def test_a_number_that_is_none_stays_none():
    logits, value, old = minibatch((), None, torch.float32)
    old.numbers[2, 3] = torch.nan
    _, by_logits, _ = categorical_losses(logits, value, old, PPOConfig())
    assert by_logits[3].isnan().all() and by_logits[4].isfinite().all()


@pytest.mark.parametrize("sizes", [[8, 8, 8], [8, 8, 3], [5], [4, 1, 7]])
@pytest.mark.parametrize("agents", [(), (2,)])
def test_advantages_are_normalized_in_each_minibatch(sizes, agents):
    advantage = 3 * torch.randn(sum(sizes), *agents, generator=torch_generator(0)) + 1
    found = advantage.clone()
    normalize(found, sizes)
    for ours, given in zip(found.split(sizes), advantage.split(sizes), strict=True):
        wanted = given if len(given) == 1 else (given - given.mean(0)) / (given.std(0) + 1e-8)
        torch.testing.assert_close(ours, wanted)


@pytest.mark.parametrize("agents", [(), (2,)])
def test_means_are_those_of_minibatches_of_unequal_sizes(agents):
    draw = torch_generator(0)
    each = [Losses(*torch.randn(4, rows, *agents, generator=draw)) for rows in (7, 7, 3)]
    found = means([(part, torch.tensor(norm)) for part, norm in zip(each, (1.0, 2.0, 6.0), strict=True)], 0.2)
    assert found["grad_norm"] == 3.0
    clipped = [((part.log_ratio.exp() - 1).abs() > 0.2).float().mean() for part in each]
    wanted = {
        "policy_loss": [-part.surrogate.mean() for part in each],
        "value_loss": [part.error.mean() for part in each],
        "entropy": [part.entropy.mean() for part in each],
        "approx_kl": [approx_kl(part.log_ratio).mean() for part in each],
        "clip_fraction": clipped,
    }
    for name, values in wanted.items():
        assert found[name] == pytest.approx(float(np.mean(values)), rel=1e-5)
    assert len(found) == (6 if not agents else 10)
    if agents:
        second = np.mean([part.entropy[:, 1].mean() for part in each])
        assert found["agent_1/entropy"] == pytest.approx(float(second), rel=1e-5)


SETTINGS = [
    {},
    {"clip_vloss": True},
    {"norm_adv": False},
    {"target_kl": 1e-3},
    {"shared_torso": True, "hidden_layers": 1},
    {"hidden_layers": 3},
    {"memory": "gru"},
]


def ways(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Yield by hand, the closed form, and the formula, each while it is the one that is used."""
    yield "by hand"
    monkeypatch.setattr(backprop, "has_tanh_layers", lambda student: False)
    yield "closed form"
    monkeypatch.setattr(backprop, "Categorical", type(None))  # no policy is one
    yield "formula"


@pytest.mark.slow
@pytest.mark.sample(6)
@pytest.mark.parametrize("regularized", [False, True])
@pytest.mark.parametrize("settings", SETTINGS)
def test_students_learn_the_same_by_hand_from_the_closed_form_and_from_autograd(settings, regularized, monkeypatch):
    quick = PPOConfig(num_steps=30, num_minibatches=4, hidden_size=16, learning_rate=3e-3)
    config = dataclasses.replace(quick, **settings)
    other = DR(Follow(), config, seed=5).student
    outcomes = {}
    for way in ways(monkeypatch):
        method = DR(Follow(), config, seed=1)
        method.fill_rollouts()
        learner = method.learner
        logged = learner.ppo.learn(learner.rollout, regularizer=KLRegularizer(other, 0.5) if regularized else None)
        outcomes[way] = logged, learner.student.state_dict()
    theirs, wanted = outcomes["formula"]
    for way in ("by hand", "closed form"):
        ours, weights = outcomes[way]
        assert ours == pytest.approx(theirs, rel=1e-3, abs=1e-6)
        assert all(torch.allclose(weights[name], wanted[name], atol=1e-5) for name in wanted)
    if settings.get("target_kl"):
        assert 0 < theirs["gradient_steps"] < 16


@pytest.mark.parametrize("shared_torso", [False, True])
@pytest.mark.parametrize("hidden_layers", [1, 2, 3])
def test_gradients_by_hand_are_those_of_autograd(shared_torso, hidden_layers):
    config = PPOConfig(hidden_size=7, hidden_layers=hidden_layers, shared_torso=shared_torso, ent_coef=0.05)
    logits, value, old = minibatch((), None, torch.float64)
    student = Student(Box(-1, 1, (6,)), Discrete(logits.shape[1]), config, torch_generator(0)).double()
    for weight in student.parameters():
        torch.nn.init.normal_(weight, std=0.5, generator=torch_generator(weight.numel()))
        weight.grad = torch.full_like(weight, torch.nan)  # to be written, not added to
    seen = torch.randn(ROWS, 6, generator=torch_generator(2), dtype=torch.float64)
    assert has_tanh_layers(student)
    parts = by_hand(student, seen, old, config)
    policy, value = student.policy_and_value(seen)
    wanted = losses(policy, value, old, config)
    for ours, theirs in zip(parts, wanted, strict=True):
        torch.testing.assert_close(ours, theirs.detach(), atol=1e-12, rtol=1e-12)
    expected = torch.autograd.grad(wanted.total(config), list(student.parameters()))
    for weight, gradient in zip(student.parameters(), expected, strict=True):
        torch.testing.assert_close(weight.grad, gradient, atol=1e-12, rtol=1e-12)


FROZEN = ["actor_torso", "critic_torso", "actor.", "critic.", "actor", "critic", "actor_torso.0.bias"]


@pytest.mark.slow
@pytest.mark.parametrize("shared_torso", [False, True])
@pytest.mark.parametrize("frozen", FROZEN)
def test_frozen_weights_get_no_gradient_and_stay_as_they_are(frozen, shared_torso):
    config = PPOConfig(num_steps=30, num_minibatches=4, hidden_size=16, shared_torso=shared_torso)
    method = DR(Follow(), config, seed=1)
    weights = dict(method.student.named_parameters())
    some = {name for name in weights if name.startswith(tuple(frozen.split()))}
    for name in some:
        weights[name].requires_grad_(False)
    before = {name: weight.detach().clone() for name, weight in weights.items()}
    method.fill_rollouts()
    logged = method.learner.ppo.learn(method.learner.rollout)
    assert {name for name in weights if weights[name].equal(before[name])} == some
    assert all(weights[name].grad.eq(0).all() for name in some) and logged["grad_norm"] > 0


@pytest.mark.parametrize(
    ("space", "actions", "settings"),
    [
        (Box(-1, 1, (6,)), Box(-1, 1, (2,)), {}),
        (Box(-1, 1, (6,)), MultiDiscrete([2, 3]), {}),
        (Box(-1, 1, (6,)), Discrete(3), {"memory": "gru"}),
        (Box(0, 255, (8, 8, 3), np.uint8), Discrete(3), {}),
    ],
)
def test_other_students_are_left_to_autograd(space, actions, settings):
    assert not has_tanh_layers(Student(space, actions, PPOConfig(**settings), torch_generator(0)))
    team = Student(Box(-1, 1, (6,)), Discrete(3), PPOConfig(), torch_generator(0), agents=2)
    assert not has_tanh_layers(team)
