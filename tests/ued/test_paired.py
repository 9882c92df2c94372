"""PAIRED on a landscape of known regret, with counts, masks, and both students on the same levels."""

import dataclasses

import numpy as np
import pytest
from probes import Choice, Free, HalfValid, Landscape

from ued.config import AdversaryConfig, PairedConfig, PairedLiteralConfig, PPOConfig
from ued.core.curriculum import ThetaSpace
from ued.levels.record import Origin
from ued.levels.scores import regret
from ued.methods.paired import NAMES, Paired, PairedCurriculum
from ued.methods.paired_literal import PairedLiteral

PPO = PPOConfig(num_steps=16, num_minibatches=1, update_epochs=1, hidden_size=8)
BRIEF = AdversaryConfig(update_epochs=2)  # where it need not get far


def share_near_peak(theta):
    return float((np.linalg.norm(theta - Landscape.PEAK, axis=1) < Landscape.WIDTH).mean())


@pytest.mark.slow
def test_the_adversary_moves_to_where_regret_is():
    method = Paired(Landscape(64), PPO, PairedConfig(), seed=0)
    first = method.update()
    assert share_near_peak(method.last.theta) < 0.15  # uniform: 0.096
    for _ in range(20):
        last = method.update()
    assert share_near_peak(method.last.theta) > 0.4
    assert last["regret"] > first["regret"] + 0.05
    assert last["theta_std"] > 0.1
    assert last["regret/luck"] == pytest.approx(last["regret"], abs=0.06)  # there is no skill in this landscape


@pytest.mark.slow
def test_both_students_play_the_same_levels_and_all_steps_count():
    method = Paired(Free(32), PPO, PairedConfig(episodes_per_level=3, adversary=BRIEF), seed=0)
    for _ in range(15):
        metrics = method.update()
    assert method.env_steps == metrics["env_steps"] == 2 * 15 * 16 * 32
    batch = method.last
    assert set(batch.returns) == set(batch.episodes) == set(NAMES) == set(method.students)
    assert all((count == 3).all() and len(count) == len(batch.theta) for count in batch.episodes.values())
    assert method.student is method.students["protagonist"]
    assert method.learners[0].upomdp is not method.learners[1].upomdp
    assert metrics["levels"] == len(batch.theta) > 0
    assert len(method.queue.records) < 3 * 32


def test_negative_returns_make_regret_without_a_maximum_that_starts_at_zero():
    protagonist, antagonist = np.array([[-1.0, -1.0], [0.0, 1.0]]), np.array([[-1.0, -0.5], [-1.0, -1.0]])
    assert regret(protagonist, antagonist, "max_mean").tolist() == [0.5, -1.5]
    assert regret(protagonist, antagonist, "mean_mean").tolist() == [0.25, -1.5]


def test_flexible_regret_lets_the_better_one_be_the_antagonist():
    protagonist, antagonist = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0, 0.0], [0.0, 1.0]])
    assert regret(protagonist, antagonist, "max_mean", flexible=True).tolist() == [1.0, 1.0]
    assert regret(protagonist, antagonist, "max_mean").tolist() == [-0.5, 1.0]


def test_regret_can_be_clipped_at_zero():
    scores = []
    for clip in (False, True):
        config = PairedConfig(
            clip_regret=clip, regret="mean_mean", roles="dennis2020", adversary=AdversaryConfig(min_batch=10_000)
        )
        method = Paired(Landscape(64), PPO, config, seed=0)
        method.update()
        scores.append(method.last.score)
    plain, clipped = scores
    assert plain.min() < 0
    assert (clipped == np.maximum(plain, 0)).all()


def lessons_of(config, env=None, updates=4):
    """Return what the adversary learns from (θ, scores), the level records of all updates, and their metrics."""
    method = Paired(env or Landscape(64), PPO, config, seed=0)
    lessons = []
    adversary = method.curriculum.adversary
    learn = adversary.learn
    adversary.learn = lambda proposals, scores: (
        lessons.append((adversary.theta(proposals), scores)) or learn(proposals, scores)
    )
    updated = [(method.update(), method.last.records) for _ in range(updates)]
    return lessons, np.concatenate([records for _, records in updated]), [metrics for metrics, _ in updated]


@pytest.mark.slow
def test_random_levels_are_mixed_in_and_teach_the_adversary_nothing():
    lessons, records, metrics = lessons_of(PairedConfig(dr_fraction=0.5, adversary=BRIEF))
    random = records["origin"] == Origin.RANDOM
    assert 0.4 < random.mean() < 0.6
    assert sum(update["levels/random"] for update in metrics) == random.sum()
    assert sum(len(scores) for _, scores in lessons) == (~random).sum()


@pytest.mark.slow
def test_an_invalid_proposal_is_neither_played_nor_learned_from():
    lessons, records, metrics = lessons_of(PairedConfig(dr_fraction=0.0, adversary=BRIEF), HalfValid(64))
    replaced = records["origin"] == Origin.REPLACED
    assert (records["level"]["theta"][:, 0] > 0).all()
    assert sum(update["levels/replaced"] for update in metrics) == replaced.sum() > 0.3 * len(records)
    own = np.concatenate([theta for theta, _ in lessons])
    assert (own[:, 0] > 0).all()
    assert own == pytest.approx(records["level"]["theta"][~replaced], abs=1e-6)


@pytest.mark.slow
def test_a_penalty_teaches_the_adversary_what_is_valid():
    config = PairedConfig(invalid_penalty=0.5, dr_fraction=0.0)
    lessons, *_ = lessons_of(dataclasses.replace(config, adversary=BRIEF), HalfValid(64), updates=2)
    for theta, scores in lessons:
        invalid = theta[:, 0] <= 0
        assert (scores[invalid] == -0.5).all() and (scores[~invalid] >= -0.01 - 1).all()
    method = Paired(HalfValid(64), PPO, config, seed=0)
    share = [metrics["levels/replaced"] / metrics["levels"] for metrics in (method.update() for _ in range(12))]
    assert share[0] > 0.4 and np.mean(share[-5:]) < 0.2


@pytest.mark.slow
def test_too_few_levels_wait_for_more():
    method = Paired(Landscape(64), PPO, PairedConfig(adversary=AdversaryConfig(min_batch=500, update_epochs=2)), seed=0)
    learned = ["adversary/entropy" in method.update() for _ in range(12)]
    assert not learned[0] and any(learned) and not all(learned)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_numbers():
    def run(seed):
        method = Paired(Landscape(16), PPO, PairedConfig(dr_fraction=0.2, adversary=BRIEF), seed=seed)
        metrics = [method.update() for _ in range(5)][-1]
        return {name: number for name, number in metrics.items() if not name.startswith("time/")}

    assert run(3) == run(3)
    assert run(3) != run(4)


def test_without_free_parameters_paired_is_refused():
    with pytest.raises(ValueError, match="an adversary has no parameters to choose"):
        Paired(Choice(4))


@pytest.mark.parametrize(
    ("setting", "number", "message"),
    [
        ("episodes_per_level", 0, "episodes_per_level must be at least 1, got 0"),
        ("regret", "max", "regret must be max_mean or mean_mean, got 'max'"),
        ("dr_fraction", 1.5, "dr_fraction must be between 0 and 1, got 1.5"),
        ("invalid_penalty", -1.0, "invalid_penalty must not be negative, got -1.0"),
    ],
)
def test_settings_out_of_range_are_refused(setting, number, message):
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(PairedConfig(), **{setting: number})


def test_regret_can_be_the_reward_of_the_students():
    """The letter of Algorithm 1: at the end of each episode -regret and regret, on levels that both have finished."""
    config = PairedLiteralConfig(episodes_per_level=4, clip_regret=False)
    method = PairedLiteral(Landscape(64), PPO, config, seed=0)
    learned = []
    for learner in method.learners:
        learner.ppo.learn = lambda rollout, *_: learned.append(rollout) or {}
    method.upomdp.outcome = longer(method.upomdp.outcome)
    metrics = method.update()
    score, protagonist, antagonist = method.last.score, *learned
    assert 0 < len(score) < 64 and metrics["levels"] == len(score)  # the longest levels take more than a rollout
    for rollout, sign in ((protagonist, -1), (antagonist, 1)):
        assert rollout.reward.shape == rollout.observation.shape[:2] == (16, len(score))
        assert rollout.last_value.shape == (len(score),) and not rollout.truncated.any()
        for n, regret_there in enumerate(score):
            ended = rollout.terminated[:, n]
            assert ended.sum() >= 4
            assert rollout.reward[ended, n].numpy() == pytest.approx(sign * regret_there)
            assert (rollout.reward[~ended, n] == 0).all()
    before = method.last.theta
    method.update()
    assert not np.isin(method.last.theta, before).any()  # all levels are new


def longer(outcome):
    """Cut off no episode, but let one in three of the ends pass, so that some levels take long."""
    stream = np.random.default_rng(0)

    def later(actions):
        reward, terminated, truncated = outcome(actions)
        return reward, terminated & (stream.random(len(reward)) < 0.67), truncated

    return later


def test_students_paid_by_regret_are_trained():
    method = PairedLiteral(Landscape(32), PPO, seed=0)
    for _ in range(3):
        metrics = method.update()
    assert np.isfinite(metrics["protagonist/policy_loss"]) and method.env_steps == 3 * 2 * 16 * 32


def test_an_adversary_does_not_learn_from_a_level_without_a_finite_score():
    curriculum = PairedCurriculum(ThetaSpace(2), PairedConfig(adversary=AdversaryConfig(min_batch=4)))
    records = curriculum.propose(32)
    records["returns"] = np.random.default_rng(0).random(records["returns"].shape)
    records["returns"][3, 1] = np.nan
    assert np.isfinite(curriculum.update(records)["adversary/policy_loss"])
    assert np.isfinite(curriculum.propose(3)["level"]["theta"]).all()
    records["returns"][:, 1] = np.nan
    with pytest.raises(ValueError, match="no level has a finite score"):
        curriculum.update(records)
