"""Replay and teachers begin early enough for something to be learned, however short the run and long the episodes."""

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete

from ued.config import ACCELConfig, AdversaryConfig, PairedConfig, PLRConfig, PPOConfig, RepairedConfig
from ued.core.parameters import Column, Range
from ued.core.upomdp import UPOMDP
from ued.levels.budget import Budget
from ued.methods import METHODS

PPO = PPOConfig(num_steps=16, hidden_size=8, update_epochs=1, num_minibatches=1)
LONG = 100  # steps of an episode
BUFFERED = ["robust_plr", "accel", "repaired"]
LEVELS = {"robust_plr": 1, "accel": 1, "repaired": 4, "paired": 4}  # episodes of all students on each


class Waiting(UPOMDP):
    """Episodes of LONG steps, in which the action is paid where it matches the level."""

    max_episode_steps = LONG

    def __init__(self, num_envs=16):
        super().__init__(num_envs, Box(-1, 1, (2,), np.float32), Discrete(2), (Column("x", Range(-1.0, 1.0)),))
        self.steps = np.zeros(num_envs, np.int64)

    def _seen(self):
        return np.stack([self.levels["theta"][:, 0], self.steps / LONG], 1).astype(np.float32)

    def _start(self, levels, where):
        self.steps[where] = 0
        return self._seen()

    def _advance(self, actions):
        reward = (actions == (self.levels["theta"][:, 0] > 0)).astype(float) / LONG
        self.steps += 1
        return self._seen(), reward, np.zeros(self.num_envs, bool), self.steps >= LONG, {}

    def copy(self):
        twin = Waiting(self.num_envs)
        twin.set_state(self.get_state())
        return twin

    def get_state(self):
        return {**self.level_state(), "steps": self.steps.copy()}

    def set_state(self, state):
        self.set_level_state(state, "steps")
        self.steps[:] = state["steps"]
        return self._seen()


def made(name, settings=None, env_steps=None, envs=16):
    return METHODS[name].load()(Waiting(envs), PPO, settings, 3, env_steps)


def trained(method, env_steps):
    """Train for so long; return the rows of metrics."""
    rows = []
    while method.env_steps < env_steps:
        rows.append(method.update())
    return rows


def test_long_runs_begin_as_they_always_did():
    budget = Budget(128, total=3_000_000, spent=290_000)
    assert [budget.allows_replay(offered, 1000) for offered in (0, 499, 500)] == [False, False, True]
    assert [budget.allows_lesson(waiting, 0) for waiting in (31, 32)] == [False, True]


def test_short_runs_begin_when_a_tenth_is_spent():
    budget = Budget(16, total=100_000, spent=9_999)
    assert not budget.allows_replay(16, 1000) and not budget.allows_lesson(16, 0)
    budget.spent = 10_000
    assert budget.allows_replay(1, 1000) and not budget.allows_replay(0, 1000)
    assert budget.allows_lesson(4, 0) and not budget.allows_lesson(3, 0) and not budget.allows_lesson(4, 1)


def test_without_a_budget_a_few_levels_of_each_environment_are_enough():
    assert [Budget(16).allows_replay(offered, 1000) for offered in (63, 64)] == [False, True]
    assert [Budget(128).allows_replay(offered, 1000) for offered in (499, 500)] == [False, True]
    assert [Budget(16).allows_lesson(waiting, 0) for waiting in (15, 16)] == [False, True]
    assert [Budget(128).allows_lesson(waiting, 0) for waiting in (31, 32)] == [False, True]
    assert Budget.of(Waiting(5)).num_envs == 5


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("name", BUFFERED)
def test_students_learn_in_a_run_that_fills_no_buffer(name, known):
    """The run offers about 100 levels, a fifth of the 500 that once had to come first."""
    total = 100 * LONG * LEVELS[name]
    method = made(name, env_steps=total if known else None)
    before = {each: [w.clone() for w in student.parameters()] for each, student in method.students.items()}
    rows = trained(method, total)
    for each, student in method.students.items():
        share = np.mean([row[f"{each}/gradient_steps"] > 0 for row in rows])
        assert share > (0.5 if known else 0.15)
        assert any(not torch.equal(old, new) for old, new in zip(before[each], student.parameters(), strict=True))


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("name", ["paired", "repaired"])
def test_the_adversary_learns_in_a_run_of_few_levels(name, known):
    total = 40 * LONG * LEVELS[name]
    rows = trained(made(name, env_steps=total if known else None), total)
    lessons = sum(row["adversary/gradient_steps"] > 0 for row in rows)
    assert lessons >= (2 if known else 1)  # once there were none


@pytest.mark.long
def test_what_is_typed_is_respected():
    total = 60 * LONG
    for name, settings in (("accel", ACCELConfig(min_fill=0.5)), ("robust_plr", PLRConfig(min_fill=1.0))):
        rows = trained(made(name, settings, total), total)
        assert all(row["student/gradient_steps"] == row["student/trained_steps"] == 0 for row in rows)
    early = trained(made("robust_plr", PLRConfig(min_fill=0.0), total), total)
    steps = np.diff([0, *(row["env_steps"] for row in early)])
    learned = np.array([row["student/trained_steps"] for row in early])
    assert (learned <= steps).all() and 0 < learned.sum() < 0.9 * steps.sum()  # new levels are only looked at
    assert np.mean([row["student/gradient_steps"] > 0 for row in early]) > 0.4
    paired = PairedConfig(adversary=AdversaryConfig(min_batch=500))
    assert all(not row["adversary/gradient_steps"] for row in trained(made("paired", paired, total), total))


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", [*BUFFERED, "paired"])
def test_a_run_that_is_resumed_begins_at_the_same_step(name):
    total = 60 * LONG * LEVELS[name]
    whole = made(name, env_steps=total)
    rows, states = [], []
    while whole.env_steps < total:
        states.append(whole.state_dict())
        rows.append(whole.update())
    for begun in (1, len(rows) // 10, len(rows) // 5, len(rows) // 2):
        again = made(name, env_steps=total)
        again.load_state_dict(states[begun])
        for row in rows[begun : begun + len(rows) // 5]:
            same = again.update()
            assert {k: v for k, v in row.items() if k[:4] != "time" and v == v} == {
                k: v for k, v in same.items() if k[:4] != "time" and v == v
            }


@pytest.mark.slow
def test_replay_that_has_begun_goes_on_in_a_run_that_is_extended():
    total = 60 * LONG
    method = made("robust_plr", env_steps=total)
    trained(method, total)
    longer = made("robust_plr", env_steps=100 * total)
    longer.load_state_dict(method.state_dict())
    assert any(longer.update()["student/gradient_steps"] > 0 for _ in range(3))


def test_states_of_before_there_were_budgets_are_taken_back():
    method = made("repaired", RepairedConfig(), 100)
    state = method.state_dict()
    del state["curriculum"]["learned_at"], state["curriculum"]["buffer"]["replays"]
    method.load_state_dict(state)
    assert method.curriculum.learned_at == 0 and not method.buffer.replays
