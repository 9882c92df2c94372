"""PAIRED on a landscape of known regret, with counts, masks, and both students on the same levels."""

import dataclasses

import numpy as np
import pytest
from probes import Choice, Free, HalfValid, Landscape

from ued.config import AdversaryConfig, PairedConfig, PPOConfig
from ued.levels.record import Origin
from ued.levels.scores import regret
from ued.methods.paired import NAMES, Paired

PPO = PPOConfig(num_steps=16, num_minibatches=1, update_epochs=1, hidden_size=8)


def share_near_peak(theta):
    return float((np.linalg.norm(theta - Landscape.PEAK, axis=1) < Landscape.WIDTH).mean())


def test_the_adversary_moves_to_where_regret_is():
    method = Paired(Landscape(64), PPO, PairedConfig(), seed=0)
    first = method.update()
    assert share_near_peak(method.last.theta) < 0.15  # uniform: 0.096
    for _ in range(50):
        last = method.update()
    assert share_near_peak(method.last.theta) > 0.4
    assert last["regret"] > first["regret"] + 0.05
    assert last["theta_std"] > 0.1
    assert last["regret/luck"] == pytest.approx(last["regret"], abs=0.06)  # there is no skill in this landscape


def test_both_students_play_the_same_levels_and_all_steps_count():
    method = Paired(Free(32), PPO, PairedConfig(episodes_per_level=3), seed=0)
    for _ in range(30):
        metrics = method.update()
    assert method.env_steps == metrics["env_steps"] == 2 * 30 * 16 * 32
    batch = method.last
    assert set(batch.returns) == set(batch.episodes) == set(NAMES) == set(method.students)
    assert all((count == 3).all() and len(count) == len(batch.theta) for count in batch.episodes.values())
    assert method.student is method.students["protagonist"]
    assert method.seats[0].player.upomdp is not method.seats[1].player.upomdp
    assert metrics["levels"] == len(batch.theta) > 0
    assert len(method.queue.trials) < 3 * 32


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
            clip_regret=clip, regret="mean_mean", roles="fixed", adversary=AdversaryConfig(min_batch=10_000)
        )
        method = Paired(Landscape(64), PPO, config, seed=0)
        method.update()
        scores.append(method.last.score)
    plain, clipped = scores
    assert plain.min() < 0
    assert (clipped == np.maximum(plain, 0)).all()


def lessons_of(config, env=None, updates=4):
    """What the adversary is given to learn from, by origin."""
    method = Paired(env or Landscape(64), PPO, config, seed=0)
    given = []
    adversary = method.curriculum.teacher.adversary
    learn = adversary.learn
    adversary.learn = lambda proposals, scores: (
        given.append((adversary.theta(proposals), scores)) or learn(proposals, scores)
    )
    settled = []
    take = method.queue.take_settled
    method.queue.take_settled = lambda: settled.append(take()) or settled[-1]
    counts = [method.update() for _ in range(updates)]
    return given, np.concatenate(settled), counts


def test_random_levels_are_mixed_in_and_teach_the_adversary_nothing():
    given, settled, counts = lessons_of(PairedConfig(dr_fraction=0.5))
    random = settled["origin"] == Origin.RANDOM
    assert 0.4 < random.mean() < 0.6
    assert sum(count["levels/random"] for count in counts) == random.sum()
    assert sum(len(scores) for _, scores in given) == (~random).sum()


def test_an_invalid_proposal_is_neither_played_nor_learned_from():
    given, settled, counts = lessons_of(PairedConfig(dr_fraction=0.0), HalfValid(64))
    replaced = settled["origin"] == Origin.REPLACED
    assert (settled["level"]["theta"][:, 0] > 0).all()
    assert sum(count["levels/replaced"] for count in counts) == replaced.sum() > 0.3 * len(settled)
    own = np.concatenate([theta for theta, _ in given])
    assert (own[:, 0] > 0).all()
    assert own == pytest.approx(settled["level"]["theta"][~replaced], abs=1e-6)


def test_a_penalty_teaches_the_adversary_what_is_valid():
    given, *_ = lessons_of(PairedConfig(invalid_penalty=0.5, dr_fraction=0.0), HalfValid(64))
    for theta, scores in given:
        invalid = theta[:, 0] <= 0
        assert (scores[invalid] == -0.5).all() and (scores[~invalid] >= -0.01 - 1).all()
    method = Paired(HalfValid(64), PPO, PairedConfig(invalid_penalty=0.5, dr_fraction=0.0), seed=0)
    share = [metrics["levels/replaced"] / metrics["levels"] for metrics in (method.update() for _ in range(30))]
    assert share[0] > 0.4 and np.mean(share[-5:]) < 0.2


def test_too_few_levels_wait_for_more():
    method = Paired(Landscape(64), PPO, PairedConfig(adversary=AdversaryConfig(min_batch=500)), seed=0)
    learned = ["adversary/entropy" in method.update() for _ in range(12)]
    assert not learned[0] and any(learned) and not all(learned)


def test_the_same_seed_gives_the_same_numbers():
    def run(seed):
        method = Paired(Landscape(16), PPO, PairedConfig(dr_fraction=0.2), seed=seed)
        metrics = [method.update() for _ in range(5)][-1]
        return {name: number for name, number in metrics.items() if not name.startswith("time/")}

    assert run(3) == run(3)
    assert run(3) != run(4)


def test_without_free_parameters_paired_is_refused():
    with pytest.raises(ValueError, match="nothing for an adversary to choose"):
        Paired(Choice(4))


@pytest.mark.parametrize(
    ("setting", "number", "message"),
    [
        ("episodes_per_level", 0, "episodes_per_level must be at least 1, got 0"),
        ("regret", "max", "regret must be max_mean or mean_mean, got 'max'"),
        ("student_reward", "none", "student_reward must be environment or regret, got 'none'"),
        ("dr_fraction", 1.5, "dr_fraction must be between 0 and 1, got 1.5"),
        ("invalid_penalty", -1.0, "invalid_penalty must not be negative, got -1.0"),
    ],
)
def test_settings_out_of_range_are_refused(setting, number, message):
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(PairedConfig(), **{setting: number})


def test_regret_can_be_the_reward_of_the_students():
    """The letter of Algorithm 1: at the end of each episode -regret and regret, on levels that both have settled."""
    method = Paired(
        Landscape(64), PPO, PairedConfig(student_reward="regret", roles="fixed", episodes_per_level=4), seed=0
    )
    learned = []
    for seat in method.seats:
        seat.ppo.learn = lambda rollout, env_steps: learned.append(rollout) or {}
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
    method = Paired(Landscape(32), PPO, PairedConfig(student_reward="regret", roles="fixed"), seed=0)
    for _ in range(3):
        metrics = method.update()
    assert np.isfinite(metrics["protagonist/policy_loss"]) and method.env_steps == 3 * 2 * 16 * 32
