"""A rollout that the simulator plays in one kernel is the one that torch and single steps would play."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest
import torch

from regista.envs.football.config import FootballConfig
from regista.envs.football.vector_env import FootballVectorEnv
from scenic_lite import ScenicError
from ued import METHODS, PPOConfig
from ued.config import DRConfig
from ued.core.upomdp import steps_as_it_plays
from ued.learning import worker
from ued.learning.worker import collect

DUEL = """
param game_duration = 30
ego = LeftPlayer at (Range(60, 90), Range(-20, 20))
ball = Ball ahead of ego by 1
RightGK at (98, 0)
"""
SHORT = "param game_duration = 7\n" + DUEL.replace("param game_duration = 30\n", "")
REFUSED = DUEL + "require ego.position.x > 65\n"
BROKEN = """
behavior Divide():
    wait
    wait
    wait
    if 1 / (ego.position.x - ego.position.x) > 0:
        wait
ego = LeftPlayer at (Range(60, 90), 0)
ball = Ball at (50, 0)
RightPlayer at (95, 0), with behavior Divide()
"""
SMALL = PPOConfig(num_steps=64, hidden_size=24, num_minibatches=2, update_epochs=1, shared_torso=True)
APART = replace(SMALL, shared_torso=False, hidden_layers=1)
GRU = replace(SMALL, memory="gru", hidden_size=19)
GRU_APART = replace(APART, memory="gru")
TEAM = FootballConfig(control="2")
THREE = "LeftPlayer at (70, 10)\nLeftPlayer at (70, -10)\n"

CASES = {
    "one agent": ("dr", DUEL, SMALL, FootballConfig(), 16),
    "separate torsos": ("dr", DUEL, APART, FootballConfig(representation="simple115"), 5),
    "truncated episodes": ("plr", SHORT, APART, FootballConfig(), 19),
    "a GRU": ("plr", SHORT, GRU, FootballConfig(), 17),
    "two GRUs": ("accel", DUEL, GRU_APART, FootballConfig(rewards="scoring,checkpoints"), 33),
    "PAIRED": ("paired", DUEL, SMALL, FootballConfig(), 16),
    "PAIRED with a GRU": ("paired", SHORT, GRU, FootballConfig(), 6),
    "REPAIRED": ("repaired", DUEL, SMALL, FootballConfig(), 8),
    "refused levels": ("minimax", REFUSED, SMALL, FootballConfig(), 16),
    "SFL": ("sfl", SHORT, SMALL, FootballConfig(), 8),
    "a team": ("dr", THREE + DUEL, APART, TEAM, 7),
    "a team with memories": ("plr", THREE + SHORT, GRU_APART, TEAM, 18),
    "a shared policy": ("dr", THREE + DUEL, replace(SMALL, team="shared"), TEAM, 16),
    "a shared policy with a central critic": (
        "dr",
        THREE + SHORT,
        replace(GRU, team="shared", critic="central"),
        TEAM,
        9,
    ),
    "opponents": ("dr", DUEL, APART, FootballConfig(right_control="closest1"), 9),
}


def trained(case, compiled, monkeypatch, updates=2, config=None):
    """Return what a method does in a few updates: its rollouts, metrics, and its state."""
    monkeypatch.setattr(worker, "COMPILED", compiled)
    monkeypatch.setattr(worker, "STRIDE", 1)  # students take their turns as in the reference
    name, program, ppo, football, num_envs = case
    env = FootballVectorEnv(program, num_envs, config=football)
    method = METHODS[name].load()(env, ppo, config, seed=3, env_steps=20_000)
    method.keep_tapes()
    seen = []
    for _ in range(updates):
        metrics = method.update()
        rollouts = [
            {name: column.clone() for name, column in vars(learner.rollout).items()} for learner in method.learners
        ]
        seen.append((rollouts, method.last.records.copy(), metrics))
    assert all(learner.worker.is_compiled == compiled for learner in method.learners)
    return method, seen


def assert_same(ours, theirs):
    """Assert that two runs played the same: exactly, but for the rounding of the networks."""
    for (rollouts, records, metrics), (others, other_records, other_metrics) in zip(ours, theirs, strict=True):
        for rollout, other in zip(rollouts, others, strict=True):
            for name, column in rollout.items():
                exact = column.dtype in (torch.bool, torch.int64) or name in ("observation", "reward")
                tolerance = 0 if exact else 1e-5
                torch.testing.assert_close(
                    column, other[name], atol=tolerance, rtol=0, msg=lambda text, n=name: f"{n}: {text}"
                )
        for name in ("id", "visit", "origin", "level", "num_played", "returns", "success"):
            np.testing.assert_array_equal(records[name], other_records[name], name)
        assert metrics["env_steps"] == other_metrics["env_steps"]


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_a_compiled_rollout_is_the_one_of_single_steps(case, monkeypatch):
    method, ours = trained(case, True, monkeypatch)
    other, theirs = trained(case, False, monkeypatch)
    assert_same(ours, theirs)
    ended = sum(
        int((rollout["terminated"] | rollout["truncated"]).sum()) for rollouts, *_ in ours for rollout in rollouts
    )
    assert ended > 0
    for learner, twin in zip(method.learners, other.learners, strict=True):
        np.testing.assert_array_equal(learner.upomdp.matches, twin.upomdp.matches)
        np.testing.assert_array_equal(learner.upomdp.levels, twin.upomdp.levels)
        np.testing.assert_array_equal(learner.upomdp.episodes, twin.upomdp.episodes)
        visits = np.arange(method.queue.next_visit)
        tapes = learner.worker.tape.pop(visits), twin.worker.tape.pop(visits)
        assert tapes[0].keys() == tapes[1].keys()
        for visit in tapes[0]:
            np.testing.assert_array_equal(tapes[0][visit], tapes[1][visit])


@pytest.mark.slow
def test_one_level_per_rollout(monkeypatch):
    case, config = CASES["truncated episodes"], DRConfig(resample_level_every="rollout")
    runs = [trained(("dr", *case[1:]), compiled, monkeypatch, config=config)[1] for compiled in (True, False)]
    assert_same(*runs)


@pytest.mark.slow
def test_a_state_continues_to_the_same_numbers(monkeypatch):
    case = CASES["PAIRED with a GRU"]
    method, _ = trained(case, True, monkeypatch)
    state = method.state_dict()
    twin, _ = trained(case, True, monkeypatch, updates=1)
    twin.load_state_dict(state)
    for _ in range(2):
        ours, theirs = method.update(), twin.update()
        assert {k: v for k, v in ours.items() if not k.startswith("time/")} == pytest.approx(
            {k: v for k, v in theirs.items() if not k.startswith("time/")}, rel=0, abs=0, nan_ok=True
        )


@pytest.mark.slow
def test_a_program_that_fails_is_reported_as_in_single_steps(monkeypatch):
    errors = []
    for compiled in (True, False):
        monkeypatch.setattr(worker, "COMPILED", compiled)
        method = METHODS["dr"].load()(FootballVectorEnv(BROKEN, 4), SMALL, None, seed=0)
        with pytest.raises(ScenicError) as error:
            method.update()
        errors.append((str(error.value), method.env_steps))
    assert errors[0][0] == errors[1][0]


@pytest.mark.slow
def test_numbers_that_sample_actions_do_not_depend_on_how_many_are_drawn_at_once():
    one, two = torch.Generator().manual_seed(1), torch.Generator().manual_seed(1)
    steps = torch.stack([torch.rand((16, 2), generator=one) for _ in range(5)])
    torch.testing.assert_close(torch.rand((5, 16, 2), generator=two), steps, rtol=0, atol=0)
    assert one.get_state().equal(two.get_state())


@pytest.mark.slow
def test_a_copied_method_plays_its_own_rollouts(monkeypatch):
    method, _ = trained(CASES["a GRU"], True, monkeypatch, updates=1)
    twin = copy.deepcopy(method)
    for _ in range(2):
        rollouts = []
        for each in (method, twin):
            each.update()
            assert each.learners[0].worker.is_compiled
            rollouts.append(each.learners[0].rollout)
        for name, column in vars(rollouts[0]).items():
            torch.testing.assert_close(column, getattr(rollouts[1], name), atol=0, rtol=0, msg=name)


class Generous(FootballVectorEnv):
    """Gives another reward than the kernels know of."""

    def _advance(self, actions):
        observation, reward, *rest = super()._advance(actions)
        return observation, reward + 1.0, *rest


def test_a_subclass_that_steps_otherwise_is_not_compiled():
    learner = METHODS["dr"].load()(Generous(DUEL, 4), SMALL, None, seed=0).learners[0]
    assert not learner.worker.is_compiled
    collect([learner.worker])
    assert (learner.rollout.reward >= 1.0 - 1e-6).any()
    env = FootballVectorEnv(DUEL, 4)
    assert steps_as_it_plays(env)
    env.advance = env.advance  # as of a spy
    assert not steps_as_it_plays(env)


LATE = """
behavior Stay():
    while True:
        take SetDirection(1)
behavior Divide():
    do Stay() for Range(0.5, 3) seconds
    take SetDirection(1 / (ego.position.x - ego.position.x))
ego = LeftPlayer at (Range(60, 90), 0)
ball = Ball at (50, 0)
RightPlayer at (95, 9), with behavior Divide()
"""


def test_training_goes_on_from_what_there_is_after_an_error():
    env = FootballVectorEnv(LATE, 4)
    worker = METHODS["dr"].load()(env, SMALL, None, seed=0).learners[0].worker
    with pytest.raises(ScenicError):
        collect([worker])
    steps = int(worker.record.counters["step"][0])
    assert steps > 2
    others = env.episodes == env.episodes.min()  # matches that failed have begun their next episode
    assert 1 <= others.sum() < len(others)
    np.testing.assert_array_equal(worker.observation[others], env.observe()[others])


@pytest.mark.parametrize("spoil", [("program", 5), ("theta", 3.0), ("theta", np.nan)])
def test_levels_at_hand_that_are_none_are_refused(spoil):
    field, value = spoil
    method = METHODS["plr"].load()(FootballVectorEnv(SHORT, 4), SMALL, None, seed=0)
    assert len(method.queue.records) > 4
    method.queue.records["level"][field][4:] = value
    with pytest.raises(ValueError, match=rf"{field}.* {value:g}"):
        method.update()
