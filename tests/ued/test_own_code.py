"""Scores and networks of the user by name: they are used, resume, and are refused in a sentence if they are wrong."""

import copy
import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.ued import own_parts
from tests.ued.test_methods import PPO, frontier, numbers
from ued import (
    ACCEL,
    CENIE,
    DR,
    NCC,
    PLR,
    SFL,
    ACCELConfig,
    BufferConfig,
    CENIEConfig,
    NCCConfig,
    PLRConfig,
    PPOConfig,
    SFLConfig,
)
from ued.core import checkpoint, own_code
from ued.core.own_code import OwnCodeError
from ued.levels import scores
from ued.settings import own_names

HERE = "tests.ued.own_parts"
FILE = Path(own_parts.__file__)
SPREAD = f"{HERE}:spread"
SMALL = BufferConfig(capacity=32)
SCORED = {
    "plr": lambda rule, seed=0: PLR(frontier(), PPO, PLRConfig(score=rule, episodes_per_level=2, buffer=SMALL), seed),
    "accel": lambda rule, seed=0: ACCEL(
        frontier(), PPO, ACCELConfig(score=rule, episodes_per_level=2, buffer=SMALL), seed
    ),
    "cenie": lambda rule, seed=0: CENIE(
        frontier(), PPO, CENIEConfig(score=rule, episodes_per_level=2, buffer=SMALL), seed
    ),
    "ncc": lambda rule, seed=0: NCC(frontier(), PPO, NCCConfig(score=rule, capacity=32), seed),
    "sfl": lambda rule, seed=0: SFL(
        frontier(), PPO, SFLConfig(score=rule, candidates=16, chosen=4, choose_every=2), seed
    ),
}
OWN = dataclasses.replace(PPO, network=f"{HERE}:Net")


@pytest.mark.slow
@pytest.mark.parametrize("name", SCORED)
def test_a_score_of_the_user_scores_the_levels_of_every_method(name):
    method, looked_at = SCORED[name](SPREAD), 0
    own_parts.calls.clear()
    for _ in range(5):
        method.update()
        records = method.last.records
        judged = records[~np.isnan(records["score"])]
        np.testing.assert_allclose(judged["score"], np.nanstd(judged["returns"][:, 0], 1))
        looked_at += len(judged)
    assert looked_at and own_parts.calls and set(np.unique(judged["score"])) <= {0.0, 0.5, np.sqrt(3) / 4}


def test_a_score_from_a_file_is_that_of_the_module(tmp_path):
    (tmp_path / "my_scores.py").write_text("def one(records, best):\n    return best + 1\n")
    config = PLRConfig(score=f"{tmp_path}/my_scores.py:one")
    records = PLR(frontier(), PPO, config).curriculum.propose(3)
    records["returns"] = 2.0
    assert scores.score(config.score, records).tolist() == [3.0, 3.0, 3.0]


def test_the_file_is_found_from_another_folder(tmp_path, monkeypatch):
    (tmp_path / "here.py").write_text("def one(records, best):\n    return best\n")
    monkeypatch.chdir(tmp_path)
    config = PLRConfig(score="here.py:one")
    monkeypatch.chdir("/")
    assert config.score == f"{tmp_path}/here.py:one" and callable(scores.find(config.score))
    assert own_names(config) == [config.score] and own_names(PPOConfig()) == []


def test_a_score_cannot_change_the_results():
    records = SCORED["plr"](SPREAD).curriculum.propose(4)
    records["returns"] = np.array([[0.0, 1.0]])
    assert scores.score(f"{HERE}:vandal", records).tolist() == [0, 1, 2, 3]
    assert records["returns"].mean() == 0.5


@pytest.mark.parametrize(
    ("rule", "message"),
    {
        f"{HERE}:short": r"short must be a finite number for each of 4 levels, got shape \[3\] of float64",
        f"{HERE}:missing": r"missing must be a finite number for each of 4 levels, got nan for level -?\d+ \(theta \[",
        f"{HERE}:masked": r"masked must be a finite number for each of 4 levels, got masked_array\(data=\[0, --, 0, 0",
        f"{HERE}:failing": r"failing failed \(.*own_parts.py:\d+\): ValueError: no field of name no_such_field",
    }.items(),
)
def test_scores_that_are_none_are_refused(rule, message):
    records = SCORED["plr"](SPREAD).curriculum.propose(4)
    records["returns"] = 0.0
    with pytest.raises(OwnCodeError, match=message):
        scores.score(rule, records)


@pytest.mark.parametrize(
    ("rule", "message"),
    {
        f"{HERE}:short": r"short must be a finite number for each of 8 levels, got shape \[3\] of float64",
        f"{HERE}:missing": r"missing must be .* got nan for level 0 \(theta \[.*\], seed \d+, returns \[0.*7 others",
        f"{HERE}:failing": r"failing failed \(.*own_parts.py:\d+\): ValueError: no field of name no_such_field",
        f"{HERE}:leaving_score": r"leaving_score failed \(.*own_parts.py:\d+\): SystemExit: 3",
        f"{HERE}:alone": r"alone failed \(.*own_parts.py:\d+\): TypeError: alone\(\) takes 1 positional argument but 2",
    }.items(),
)
@pytest.mark.parametrize("method", SCORED)
def test_a_wrong_score_is_found_before_training(method, rule, message):
    with pytest.raises(OwnCodeError, match=message):
        SCORED[method](rule)


@pytest.mark.parametrize("method", SCORED)
def test_trying_a_score_changes_no_level_and_uses_every_field(method):
    """Levels of a run with a score of the user are those of a run with the same score of ours."""
    tried, ours = SCORED[method](f"{HERE}:learnable"), SCORED[method]("learnability")
    for one in (tried, ours):
        one.update()
    assert (tried.last.records["level"] == ours.last.records["level"]).all()
    if method == "cenie":
        SCORED[method](f"{HERE}:novel")


def test_an_update_without_levels_calls_no_score():
    records = SCORED["plr"](SPREAD).curriculum.propose(4)[:0]
    assert scores.score(f"{HERE}:failing", records).shape == (0,)


@pytest.mark.parametrize(
    ("rule", "message"),
    {
        f"{HERE}:spred": r"tests.ued.own_parts has no 'spred' \(did you mean 'spread'\?\)",
        f"{HERE}:calls": r"must be a function of level records and best returns, got \[",
        "no_such_module:spread": "no_such_module cannot be imported: ModuleNotFoundError",
        "/no/such/file.py:spread": "there is no file /no/such/file.py, which /no/such/file.py:spread names",
    }.items(),
)
@pytest.mark.parametrize("method", ["plr", "ncc", "sfl"])
def test_a_missing_score_is_found_before_training(method, rule, message):
    with pytest.raises(OwnCodeError, match=message):
        SCORED[method](rule)


@pytest.mark.parametrize("config", [PLRConfig, ACCELConfig, CENIEConfig, NCCConfig])
def test_a_score_that_nobody_knows(config):
    with pytest.raises(
        ValueError, match=r"score must be max_mc or .* or your own, module:function or file.py:function"
    ):
        config(score="max_mcc")


def test_a_network_that_nobody_knows():
    with pytest.raises(ValueError, match="network must be auto or mlp or cnn, or your own, module:class or"):
        PPOConfig(network="resnet")
    with pytest.raises(ValueError, match="score must be learnability or generalized_learnability, or your own"):
        SFLConfig(score="mna")


@pytest.mark.parametrize("memory", ["none", "gru"])
@pytest.mark.parametrize("shared", [False, True])
def test_a_network_of_the_user_learns_with_our_memory_and_heads(memory, shared):
    ppo = dataclasses.replace(OWN, memory=memory, shared_torso=shared, head_size=8, norm_reward=True)
    method = DR(frontier(), ppo, seed=0)
    assert type(method.student.actor_torso[0]) is own_parts.Net
    assert (method.student.critic_torso is method.student.actor_torso) == shared
    before = {name: weight.clone() for name, weight in method.student.state_dict().items()}
    method.update()
    learned = [name for name, weight in method.student.state_dict().items() if not torch.equal(weight, before[name])]
    assert any("actor_torso.0.second" in name for name in learned) and not method.learner.worker.is_compiled


def test_weights_follow_from_the_seed_of_the_run_alone():
    torch.manual_seed(5)
    state = torch.get_rng_state()
    one, other, third = (DR(frontier(), OWN, seed=seed).student.actor_torso[0] for seed in (0, 0, 1))
    assert torch.equal(torch.get_rng_state(), state)
    assert torch.equal(one.second.weight, other.second.weight) and not torch.equal(
        one.second.weight, third.second.weight
    )


@pytest.mark.slow
def test_runs_with_own_parts_resume_bit_for_bit(tmp_path):
    config = PLRConfig(score=SPREAD, episodes_per_level=2, buffer=SMALL)
    method = PLR(frontier(), OWN, config, 0)
    for _ in range(4):
        method.update()
    checkpoint.save(tmp_path / "c.pt", method.state_dict())
    resumed = PLR(frontier(), OWN, config, 3)
    resumed.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    for _ in range(3):
        one, other = numbers(method.update()), numbers(resumed.update())
        np.testing.assert_array_equal(list(one.values()), list(other.values()))


@pytest.mark.parametrize(
    ("name", "message"),
    {
        "Noisy": "own_parts:Noisy draws random numbers in forward, as dropout does: PPO needs equal",
        "FunctionalNoise": "draws random numbers in forward",
        "RecurrentNoise": "draws random numbers in forward",
        "Counting": "Counting returns other features when it is called again on the same observations",
        "Spectral": r"Spectral changes its first.parametrizations.weight.0._\w in forward, as batch and spect",
        "Normed": "Normed changes its norm.num_batches_tracked in forward",
        "Centered": "Centered mixes the rows of a batch: the features of an observation depend on the others",
        "UnsavedWaves": "UnsavedWaves has values that are not saved with its weights .* register_buffer",
        "Cut": "no gradient reaches first.weight, first.bias, second.weight, … of tests.ued.own_parts:Cut",
        "Unlisted": "Unlisted uses weights that are not registered, so PPO would neither train nor save them; hold we",
        "Wide": r"Wide must return float32 features, \[B, size\] for B observations; for 4 got .* of torch.float64",
        "WideWeights": "WideWeights must have float32 weights, but its layer.weight is torch.float64",
        "InPlace": "InPlace changes its observations in place; make new ones",
        "Undefined": r"Undefined returned NaN or infinity for observations in \[0, 1\)",
        "Flat": r"own_parts:Flat must return float32 features, \[B, size\] for B observations; for 4 got \[4\]",
        "Squeezed": r"Squeezed must return float32 features, \[B, size\] for B observations; for 1 got \[16\]",
        "Broken": r"own_parts:Broken failed on float32 observations \[B, 10\]: RuntimeError",
        "leaving": r"own_parts:leaving\(space, config\) failed: SystemExit: 3",
        "no_network": r"own_parts:no_network\(space, config\) must return a torch.nn.Module, got 'a network'",
        "calls": r"own_parts:calls\(space, config\) failed: TypeError",
    }.items(),
)
def test_networks_that_are_none_are_refused(name, message):
    with pytest.raises(OwnCodeError, match=message):
        DR(frontier(), dataclasses.replace(PPO, network=f"{HERE}:{name}"))


def test_a_layer_that_learns_nothing_is_a_warning():
    with pytest.warns(UserWarning, match=r"no gradient reaches spare.weight, spare.bias of .*own_parts:Unused"):
        student = DR(frontier(), dataclasses.replace(PPO, network=f"{HERE}:Unused")).student
    copy.deepcopy(student)  # the features that it keeps have no gradient


@pytest.mark.parametrize("name", ["Quiet", "Frozen", "Waves"])
def test_networks_that_only_look_wrong_learn(name):
    DR(frontier(), dataclasses.replace(PPO, network=f"{HERE}:{name}")).update()


def test_agents_of_one_policy_share_a_network_of_the_user():
    from tests.ued.test_team import Roles

    ppo = dataclasses.replace(OWN, team="shared", critic="central")
    metrics = DR(Roles(4), ppo, seed=0).update()
    assert metrics["student/gradient_steps"] > 0
    with pytest.raises(OwnCodeError, match=r"supports one policy: several agents need team='shared' \(--team shared"):
        DR(Roles(4), OWN, seed=0)


def test_compiled_simulators_fall_back_to_torch():
    from regista.envs.maze.env import Mazes

    own, ours = (DR(Mazes(4), ppo, None, 0) for ppo in (OWN, PPO))
    assert ours.learner.worker.is_compiled and not own.learner.worker.is_compiled
    assert own.update()["student/gradient_steps"] > 0


def test_a_name_from_a_file_needs_trust():
    name = f"{FILE}:lowest"
    assert callable(own_code.load(name))
    own_code.note_read(name)
    try:
        with pytest.raises(Exception, match=r"a file names .*own_parts.py:lowest, which is Python code"):
            own_code.load(name)
    finally:
        own_code._noted.clear()
