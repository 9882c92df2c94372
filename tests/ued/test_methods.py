"""Every method on a probe: what its paper says must change in an update, and what must not."""

import copy
import inspect
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from probes import Choice

import ued
from ued import (
    ACCEL,
    ALPGMM,
    CENIE,
    DR,
    NCC,
    PLR,
    SFL,
    ACCELConfig,
    BufferConfig,
    CENIEConfig,
    Lessons,
    LessonsConfig,
    Minimax,
    MinimaxConfig,
    NCCConfig,
    Paired,
    PairedConfig,
    PairedLiteral,
    PLRConfig,
    PPOConfig,
    Repaired,
    RepairedConfig,
    RobustPLR,
    SelfRegret,
    SFLConfig,
)
from ued.config import AdversaryConfig, ALPGMMConfig
from ued.core import checkpoint
from ued.core.curriculum import ThetaSpace
from ued.core.parameters import edit, numbered
from ued.levels.record import NONE, Origin
from ued.methods.method import Method
from ued.methods.paired import kl_target
from ued.methods.sfl import SFLCurriculum
from ued.probes import Frontier

PPO = PPOConfig(num_steps=32, num_minibatches=2, update_epochs=2, hidden_size=16)
SMALL = BufferConfig(capacity=64)
METHODS = {
    "dr": lambda env, seed=0: DR(env, PPO, seed=seed),
    "minimax": lambda env, seed=0: Minimax(env, PPO, seed=seed),
    "paired": lambda env, seed=0: Paired(env, PPO, seed=seed),
    "paired_kl": lambda env, seed=0: Paired(env, PPO, PairedConfig(kl="both_ways", kl_every=1), seed),
    "paired_population": lambda env, seed=0: Paired(env, PPO, PairedConfig(students=3), seed),
    "paired_scripted": lambda env, seed=0: Paired(env, PPO, PairedConfig(antagonist="scripted"), seed),
    "paired_literal": lambda env, seed=0: PairedLiteral(env, PPO, seed=seed),
    "paired_image": lambda env, seed=0: Paired(
        env, PPO, PairedConfig(adversary=AdversaryConfig(context="observation", distribution="beta")), seed
    ),
    "self_regret": lambda env, seed=0: SelfRegret(env, PPO, seed=seed),
    "repaired": lambda env, seed=0: Repaired(env, PPO, RepairedConfig(buffer=SMALL), seed),
    "plr": lambda env, seed=0: PLR(env, PPO, PLRConfig(buffer=SMALL), seed),
    "robust_plr": lambda env, seed=0: RobustPLR(env, PPO, PLRConfig(buffer=SMALL), seed),
    "accel": lambda env, seed=0: ACCEL(env, PPO, ACCELConfig(buffer=SMALL), seed),
    "cenie": lambda env, seed=0: CENIE(env, PPO, CENIEConfig(buffer=SMALL), seed),
    "plr_cenie": lambda env, seed=0: CENIE(env, PPO, CENIEConfig(buffer=SMALL, base="plr"), seed),
    "sfl": lambda env, seed=0: SFL(env, PPO, SFLConfig(candidates=32, chosen=8, choose_every=3), seed),
    "mna": lambda env, seed=0: PLR(env, PPO, PLRConfig(score="mna", buffer=SMALL), seed),
    "ncc": lambda env, seed=0: NCC(env, PPO, NCCConfig(capacity=32), seed),
    "alp_gmm": lambda env, seed=0: ALPGMM(env, PPO, ALPGMMConfig(fit_every=60, max_components=3), seed),
    "lessons": lambda env, seed=0: Lessons(env, PPO, LessonsConfig(increments=4, window=20), seed),
    "norm_reward": lambda env, seed=0: DR(env, replace(PPO, norm_reward=True), seed=seed),
}


def frontier(num_envs=16):
    return Frontier(num_envs, longest=8, dim=3)


def weights(student):
    return copy.deepcopy(student.state_dict())


def changed(student, before):
    return any(not torch.equal(value, before[name]) for name, value in student.state_dict().items())


def numbers(metrics):
    return {name: number for name, number in metrics.items() if not name.startswith("time/")}


def observed(method):
    """Collect the level records of later updates."""
    seen, update = [], method.update

    def note():
        metrics = update()
        seen.append(method.last.records)
        return metrics

    method.update = note
    return seen


QUICK = (
    "dr",
    "paired",
    "robust_plr",
    "cenie",
    "alp_gmm",
)  # of each kind of teacher one; the others take a minute together


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in METHODS]
)
def test_updates_count_all_steps_and_resume_bit_for_bit(name, tmp_path):
    method = METHODS[name](frontier())
    for _ in range(6):
        metrics = method.update()
    learners = len(method.learners)
    assert metrics["env_steps"] == method.env_steps == 6 * 32 * 16 * learners
    assert metrics["levels"] == len(method.last.theta) > 0
    assert sum(metrics[f"levels/{origin.name.lower()}"] for origin in Origin) == metrics["levels"]
    checkpoint.save(tmp_path / "c.pt", method.state_dict())
    resumed = METHODS[name](frontier(), seed=5)
    resumed.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    for _ in range(3):
        one, other = numbers(method.update()), numbers(resumed.update())
        assert one.keys() == other.keys()
        assert all(one[key] == other[key] or one[key] != one[key] for key in one)
    assert not changed(resumed.student, weights(method.student))


@pytest.mark.slow
@pytest.mark.sample(4)
@pytest.mark.parametrize("name", ["robust_plr", "accel", "cenie", "plr_cenie", "repaired"])
def test_robust_methods_learn_nothing_from_new_levels(name):
    method = METHODS[name](frontier(4))
    before = {each: weights(student) for each, student in method.students.items()}
    seen = observed(method)
    while not method.curriculum.buffer.replays:
        method.update()
        if not method.curriculum.buffer.replays:
            assert all((records["origin"] != Origin.REPLAYED).all() and not records["train"].any() for records in seen)
            assert not any(changed(method.students[each], old) for each, old in before.items())
    for _ in range(4):
        method.update()
    assert all(changed(method.students[each], old) for each, old in before.items())


@pytest.mark.slow
def test_robust_plr_learns_from_exactly_the_replayed_steps():
    method = METHODS["robust_plr"](frontier())
    while method.curriculum.buffer.fill_ratio < 0.5:
        method.update()
    shares = []
    for _ in range(12):
        method.update()
        shares.append(method.learner.rollout.train.float().mean().item())
        playing = method.queue.records[method.queue.playing[0]]
        assert (playing["train"] == (playing["origin"] == Origin.REPLAYED)).all()
    assert 0.2 < np.mean(shares[3:]) < 0.8


@pytest.mark.slow
def test_plr_learns_from_every_level_and_replays_what_scores():
    method = METHODS["plr"](frontier())
    before = weights(method.student)
    method.update()
    assert changed(method.student, before)
    seen = observed(method)
    for _ in range(30):
        method.update()
    records = np.concatenate(seen)
    replayed = records[records["origin"] == Origin.REPLAYED]
    assert records["train"].all() and 0.3 < len(replayed) / len(records) < 0.7
    new = records[records["origin"] == Origin.RANDOM]
    assert len(new) + len(replayed) == len(records) and len(np.unique(new["id"])) == len(new)
    assert (replayed["id"] != NONE).all() and not (np.diff(new["id"][np.argsort(new["id"])]) > 20).any()
    short = method.upomdp.length(replayed["level"]["theta"]) <= 3
    assert short.mean() > (method.upomdp.length(new["level"]["theta"]) <= 3).mean()


def test_plr_writes_new_scores_of_replayed_levels():
    method = METHODS["plr"](frontier())
    while method.curriculum.buffer.fill_ratio < 1:
        method.update()
    seen = observed(method)
    method.update()
    records = seen[-1][seen[-1]["origin"] == Origin.REPLAYED]
    buffer = method.curriculum.buffer
    rows = buffer.find(records["id"])
    last = {int(level): value for level, value in zip(records["id"], records["score"], strict=True)}
    for row, level in zip(rows, records["id"], strict=True):
        if row != NONE:
            assert buffer.slots["score"][row] == last[int(level)]


@pytest.mark.slow
def test_accel_edits_what_was_replayed_and_only_looks_at_the_children():
    method = METHODS["accel"](frontier())
    seen = observed(method)
    for _ in range(60):
        method.update()
    records = np.concatenate(seen)
    children = records[records["origin"] == Origin.EDITED]
    assert len(children) > 50 and not children["train"].any() and np.isin(children["parent"], records["id"]).all()
    replays = (records["origin"] == Origin.REPLAYED).sum()
    assert abs(len(children) - replays) < 0.2 * replays  # one child for each replay
    assert method.curriculum.buffer.slots["generation"].max() >= 2


def test_edits_move_few_columns_a_little_and_stay_inside():
    rng, config = np.random.default_rng(0), ACCELConfig(num_edits=2, edit_size=0.1)
    theta = rng.uniform(-1, 1, (500, 6))
    draws = numbered("theta", 6)
    moved = edit(theta, draws, config.num_edits, config.edit_size, rng) - theta
    assert ((moved != 0).sum(1) <= 2).all() and np.abs(moved).max() <= 0.2 and (moved != 0).any(1).all()
    assert np.abs(edit(np.ones((50, 6)), draws, config.num_edits, config.edit_size, rng)).max() <= 1


def test_minimax_is_paid_the_mean_return_negated():
    method = Minimax(frontier(), PPO, MinimaxConfig(episodes_per_level=3))
    seen = observed(method)
    method.update()
    assert (seen[0]["score"] == -seen[0]["returns"][:, 0].mean(1)).all()


def test_self_regret_compares_later_with_earlier_episodes():
    method = METHODS["self_regret"](frontier())
    seen = observed(method)
    method.update()
    returns = seen[0]["returns"][:, 0]
    assert returns.shape[1] == 4
    assert (seen[0]["score"] == returns[:, 2:].max(1) - returns[:, :2].mean(1)).all()


@pytest.mark.slow
def test_regret_is_antagonist_minus_protagonist_on_a_scripted_pair():
    method = METHODS["paired_scripted"](frontier())
    seen = observed(method)
    for _ in range(3):
        method.update()
    records = np.concatenate(seen)
    assert set(method.students) == {"protagonist"}
    solvable = ~method.upomdp.blocked(records["level"]["theta"])
    assert (records["returns"][:, 1] == solvable[:, None]).all()  # it knows every turn
    assert records["score"] == pytest.approx(solvable - records["returns"][:, 0].mean(1))


def test_a_population_has_no_fixed_parts():
    method = METHODS["paired_population"](frontier())
    seen = observed(method)
    method.update()
    assert set(method.students) == {"student0", "student1", "student2"}
    returns = seen[0]["returns"]
    assert seen[0]["score"] == pytest.approx(returns.max(2).max(1) - returns.mean((1, 2)))


@pytest.mark.parametrize(("kl", "regularized"), [("one_way", 1), ("both_ways", 2), ("none", 0)])
def test_students_are_kept_close_to_each_other(kl, regularized):
    config = PairedConfig(kl=kl, kl_every=2)
    learners = Paired(frontier(), PPO, config).learners
    targets = [[kl_target(config, learners, learner, updates) for learner in learners] for updates in range(2)]
    assert sum(target is not None for target in targets[0]) == regularized
    assert targets[1] == [None, None]
    if regularized:
        assert targets[0][0].student is learners[1].student


@pytest.mark.slow
@pytest.mark.long
def test_the_regularizer_brings_policies_together():
    distances = []
    for coef in (0.0, 5.0):
        config = PairedConfig(kl="both_ways", kl_every=1, kl_coef=coef)
        method = Paired(frontier(), PPO, config)
        for _ in range(40):  # before, both have hardly left where they began
            method.update()
        seen = method.learners[0].rollout.observation.flatten(0, 1)
        with torch.no_grad():
            one, other = (student(seen)[0] for student in method.students.values())
            distances.append(float(one.kl(other).mean()))
    assert distances[1] < 0.2 * distances[0]


@pytest.mark.slow
def test_the_adversary_of_repaired_learns_only_from_what_it_proposed():
    method = METHODS["repaired"](frontier())
    batches, adversary = [], method.curriculum.adversary
    learn = adversary.learn
    adversary.learn = lambda proposals, scores: batches.append(len(scores)) or learn(proposals, scores)
    seen = observed(method)
    for _ in range(20):
        method.update()
    records = np.concatenate(seen)
    replayed = records["origin"] == Origin.REPLAYED
    assert replayed.sum() > 20
    own = int((records["origin"] == Origin.PROPOSED).sum())
    assert sum(batches) + len(method.curriculum.pending_proposals) == own
    assert (records["train"] == replayed).all()
    assert not np.isnan(records["returns"][replayed]).any()  # both students played the same replayed level


def test_sfl_chooses_even_where_looking_takes_longer_than_the_time_between_two_choices():
    """One candidate is judged in each update, 12 of them in the time of four choices."""
    levels = SFLCurriculum(ThetaSpace(2), SFLConfig(candidates=12, chosen=3, choose_every=3, candidate_episodes=2))
    levels.update(levels.propose(4)[:0])
    records = levels.propose(12)
    assert not records["train"].any()
    records["returns"][:, 0] = np.stack([np.arange(12) % 2, np.zeros(12)], 1)  # every second is learnable
    for k in range(12):
        metrics = levels.update(records[k : k + 1])
    assert metrics["sfl/chosen_score"] == pytest.approx(0.5 + 0.0005)  # p (1 - p) n / (n - 1), and the tie-break
    again = levels.propose(100)
    again = again[again["origin"] == Origin.REPLAYED]
    assert len(again) and np.isin(again["level"]["theta"], records["level"]["theta"][1::2]).all()


def test_sfl_without_a_success_chooses_levels_whose_returns_vary():
    config = SFLConfig(candidates=12, chosen=3, choose_every=3, candidate_episodes=2, score="generalized_learnability")
    levels = SFLCurriculum(ThetaSpace(2), config)
    levels.update(levels.propose(4)[:0])
    records = levels.propose(12)
    records["returns"][:, 0] = -500.0 + np.stack([np.arange(12), -np.arange(12)], 1)  # no return is above 0
    for k in range(0, 12, 4):
        metrics = levels.update(records[k : k + 4])
    assert metrics["sfl/chosen_score"] == pytest.approx(10 * np.sqrt(2))  # of 11, 10 and 9: all means are equal
    assert np.isin(levels.chosen["level"]["theta"], records["level"]["theta"][9:]).all()


@pytest.mark.slow
def test_sfl_counts_its_looking_around_and_trains_on_the_chosen():
    method = METHODS["sfl"](frontier())
    seen = observed(method)
    for _ in range(20):
        method.update()
    records = np.concatenate(seen)
    looked_at = ~records["train"]
    assert looked_at.any() and (records["num_played"][looked_at] == 4).all()
    assert (records["num_played"][~looked_at] == 1).all()
    again = records[records["origin"] == Origin.REPLAYED]
    assert len(again) and np.isin(again["level"]["theta"], records["level"]["theta"][looked_at]).all()


@pytest.mark.slow
def test_alp_gmm_goes_where_returns_change():
    method = METHODS["alp_gmm"](frontier())
    seen = observed(method)
    for _ in range(40):
        method.update()
    records = np.concatenate(seen[-15:])
    focused, random = (records[records["origin"] == origin] for origin in (Origin.PROPOSED, Origin.RANDOM))
    assert method.curriculum.mixture is not None and len(focused) > len(random) > 0
    length = method.upomdp.length
    assert length(focused["level"]["theta"]).mean() < length(random["level"]["theta"]).mean() - 0.5


@pytest.mark.parametrize("name", ["minimax", "paired", "accel", "alp_gmm"])
def test_methods_that_choose_theta_need_one(name):
    with pytest.raises(ValueError, match=r"no parameters to choose|no free parameters"):
        METHODS[name](Choice(4))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PairedConfig(students=1), "students must be at least 2, got 1"),
        (lambda: PairedConfig(students=3, roles="flexible"), "more than two students have no antagonist"),
        (lambda: PairedConfig(antagonist="scripted", kl="one_way"), "a scripted antagonist cannot be regularized"),
        (lambda: PLRConfig(score="learnability"), "learnability needs episodes_per_level of at least 2, got 1"),
        (lambda: NCCConfig(episodes_per_level=1), "learnability needs episodes_per_level of at least 2, got 1"),
        (lambda: NCCConfig(candidate_share=0.5, rescore_share=0.5), r"less than 1 together, got \(0.5, 0.5\)"),
        (lambda: SFLConfig(chosen=300), r"chosen must be at most candidates \(256\), got 300"),
        (lambda: SFLConfig(candidate_episodes=1), "candidate_episodes must be at least 2, got 1"),
        (lambda: ALPGMMConfig(fit_every=5), r"fit_every must be above max_components \(10\), got 5"),
    ],
)
def test_settings_that_contradict_each_other_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_the_adversary_can_look_at_what_students_see():
    method = METHODS["paired_image"](frontier())
    method.update()
    z = method.queue.records["z"]
    assert z.shape[1] == 10 and (z[:, 0] == 1).all()  # at the first place of the path
    assert len(np.unique(z[:, -1])) > 2  # of random lengths


def test_an_update_is_its_papers_box():
    """Each method file has its own, of at most 25 lines, and no class stands between it and `Method`."""
    for row in ued.METHODS.values():
        cls = row.load()
        assert Method in cls.__bases__ or Method in cls.__base__.__bases__
        assert len(inspect.getsource(cls.update).splitlines()) <= 25
        assert inspect.getsourcefile(cls.update) == inspect.getsourcefile(cls)
        assert cls.__module__ == row.module
    made = {name for name, value in vars(Method).items() if callable(value) and not name.startswith("_")}
    for row in ued.METHODS.values():  # nothing of the base class is overridden but what it leaves open
        assert made & vars(row.load()).keys() <= {"setup", "update"}


@pytest.mark.slow
def test_every_metric_is_explained_in_the_docs():
    page = (Path(ued.__file__).parent.parent / "docs" / "files.md").read_text()
    explained = set(
        re.findall(r"^\| `([^`]+)` \|", page[page.index("### metrics.csv") : page.index("### levels.csv")], re.M)
    )
    explained = {"updates" if name == "update" else name for name in explained}
    logged = set()
    for make in METHODS.values():
        method = make(frontier())
        names = {name for _ in range(6) for name in method.update()}
        for student in [learner.name for learner in method.learners]:
            names = {re.sub(rf"(^|/){student}(/|$)", r"\1NAME\2", name) for name in names}
        logged |= names
    elsewhere = {name for name in explained if "/agent_" in name}  # tests/ued/test_team.py finds these
    elsewhere |= {
        "eval/SCENE",
        "eval_low/SCENE",
        "eval_high/SCENE",
        "eval_success/SCENE",
        "eval_env_steps",
        "time/eval",
        "time/elapsed",
    }  # of `regista train`
    elsewhere |= {"choice_ratio/COLUMN/OPTION", "choice_score/COLUMN/OPTION"}  # of choices: test_proposals.py
    elsewhere |= {"program/NAME", "program_success/NAME"}  # and tests/ued/test_mixture.py those of mixtures
    assert logged == explained - elsewhere
