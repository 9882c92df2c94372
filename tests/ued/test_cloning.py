"""Behavior cloning: it learns what was done, of one agent and of several, and goes on as if it had never stopped."""

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete

from ued.config import CloningConfig, PPOConfig
from ued.core.seeding import torch_generator
from ued.learning.cloning import Agreement, Cloner, Demonstrated, discounted
from ued.learning.student import Student

SEEN, ACTIONS = Box(-np.inf, np.inf, (3,)), Discrete(4)


def student(agents=1):
    config = PPOConfig(hidden_size=32, hidden_layers=1)
    return Student(SEEN, ACTIONS, config, torch_generator(0), None, agents)


def steps(count, agents=1, seed=0, noise=0.0):
    """Return steps in which what is done follows from what is seen, of each agent in his own way."""
    rng = np.random.default_rng(seed)
    shape = (count, agents) if agents > 1 else (count,)
    seen = rng.normal(5.0, 20.0, (*shape, 3)).astype(np.float32)
    done = (seen[..., 0] > 5).astype(int) + 2 * (seen[..., 1] > 5)
    if agents > 1:
        done = (done + np.arange(agents)) % 4
    random = rng.random(shape) < noise
    done[random] = rng.integers(0, 4, int(random.sum()))
    returns = torch.as_tensor(rng.random(count).astype(np.float32))
    return Demonstrated(torch.as_tensor(seen), torch.as_tensor(done), torch.ones(shape, dtype=torch.bool), returns)


def cloned(cloner, data, held_out):
    cloner.look_through([data])
    while True:
        cloner.learn([data])
        if not cloner.keep_if_best(cloner.evaluate([held_out]).loss):
            return cloner.evaluate([held_out])


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("agents", [1, 3])
def test_a_student_learns_what_was_done(agents):
    cloner = Cloner(student(agents), CloningConfig(epochs=30, learning_rate=5e-3), torch_generator(1))
    found = cloned(cloner, steps(3000, agents), steps(500, agents, seed=1))
    assert found.accuracy > 0.95 and found.balanced_accuracy > 0.95
    assert found.counts.sum() == 500 * agents


def test_it_stops_when_held_out_steps_are_met_worse():
    cloner = Cloner(student(), CloningConfig(epochs=200, patience=3, learning_rate=1e-2), torch_generator(1))
    cloned(cloner, steps(60, noise=1.0), steps(200, seed=1, noise=1.0))
    assert cloner.epoch == cloner.best_epoch + 3 < 60
    assert cloner.best.keys() == cloner.student.state_dict().keys()


def test_steps_of_which_nobody_knows_are_not_learned_from():
    data = steps(500)
    unknown = Demonstrated(data.observation, torch.zeros_like(data.action), torch.zeros_like(data.mask), data.returns)
    cloner = Cloner(student(), CloningConfig(value_coef=0.0), torch_generator(1))
    cloner.look_through([unknown])
    before = cloner.student.actor.layer.weight.clone()
    cloner.learn([unknown])
    assert (cloner.student.actor.layer.weight == before).all()
    assert cloner.evaluate([unknown]).counts.sum() == 0


@pytest.mark.parametrize(("weights", "told"), [("none", (1.0, 1.0)), ("sqrt", (0.55, 2.2)), ("balanced", (0.5, 8.0))])
def test_rare_actions_can_weigh_more(weights, told):
    data = steps(1600)
    action = torch.zeros(1600, dtype=torch.int64)
    action[:100] = 2
    cloner = Cloner(student(), CloningConfig(class_weights=weights), torch_generator(1))
    cloner.look_through([Demonstrated(data.observation, action, data.mask, data.returns)])
    share = torch.tensor([1500, 0, 100, 0]) / 1600
    assert float((cloner.weights * share).sum()) == pytest.approx(1.0)
    ratio = float(cloner.weights[2] / cloner.weights[0])
    assert ratio == pytest.approx({"none": 1.0, "sqrt": 15**0.5, "balanced": 15.0}[weights], rel=1e-5)


@pytest.mark.slow
def test_the_critic_learns_what_came_of_it():
    data = steps(2000)
    returns = (data.observation[:, 2] > 5).float()
    data = Demonstrated(data.observation, data.action, data.mask, returns)
    cloner = Cloner(student(), CloningConfig(epochs=30, learning_rate=5e-3), torch_generator(1))
    assert cloned(cloner, data, data).value_loss < 0.03
    assert discounted(np.array([0.0, 0.0, 1.0]), 0.5).tolist() == [0.25, 0.5, 1.0]


def test_critics_of_opponents_learn_what_each_of_them_gets():
    data = steps(500, agents=2)
    rewards = np.array([[0.0, 0.0], [1.0, -1.0]])
    assert discounted(rewards, 0.5).tolist() == [[0.5, -0.5], [1.0, -1.0]]
    returns = torch.tensor([1.0, -1.0]).expand(500, 2)
    cloner = Cloner(student(2), CloningConfig(learning_rate=5e-3), torch_generator(1))
    cloner.look_through([data])
    for _ in range(30):
        cloner.learn([Demonstrated(data.observation, data.action, data.mask, returns)])
    value = cloner.student(data.observation)[1].mean(0)
    assert value.tolist() == pytest.approx([1.0, -1.0], abs=0.1)


def test_it_goes_on_as_if_it_had_never_stopped():
    def epochs(cloner, count):
        return [cloner.learn([data]) for _ in range(count)]

    data, config = steps(300), CloningConfig()
    whole = Cloner(student(), config, torch_generator(1))
    whole.look_through([data])
    losses = epochs(whole, 5)
    first = Cloner(student(), config, torch_generator(1))
    first.look_through([data])
    epochs(first, 2)
    first.keep_if_best(1.0)
    other = Cloner(student(), config, torch_generator(7))
    other.load_state_dict(first.state_dict())
    other.look_through([data])
    assert epochs(other, 3) == losses[2:] and other.best_epoch == 2


@pytest.mark.slow
def test_a_best_student_that_is_another_one_is_refused():
    cloner = Cloner(student(), CloningConfig(), torch_generator(1))
    cloned(cloner, steps(50), steps(50, seed=1))
    state = cloner.state_dict()
    state["best"]["actor.layer.bias"] = torch.zeros(9)
    with pytest.raises(RuntimeError, match=r"actor\.layer\.bias"):
        cloner.load_state_dict(state)
    with pytest.raises(RuntimeError, match=r"actor\.layer\.bias"):
        cloner.load_state_dict(state | {"best": {}})


def test_accuracy_is_told_by_action():
    found = Agreement(1.0, 0.0, np.array([[90, 10, 0], [5, 5, 0], [0, 0, 0]]))
    assert found.accuracy == pytest.approx(95 / 110)
    assert found.recall[:2].tolist() == [0.9, 0.5] and np.isnan(found.recall[2])
    assert found.balanced_accuracy == pytest.approx(0.7)
    assert found.precision[1] == pytest.approx(1 / 3)
