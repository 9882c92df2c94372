"""NCC: the projection, the ascent against its optimum, what is exchanged, what is counted, and resuming."""

import numpy as np
import pytest

from ued import NCC, NCCConfig, PPOConfig
from ued.core.curriculum import ThetaSpace
from ued.levels.budget import Budget
from ued.levels.record import Origin
from ued.levels.simplex import SimplexAscent, project_to_simplex
from ued.methods.ncc import NCCCurriculum
from ued.probes import Frontier

PPO = PPOConfig(num_steps=32, num_minibatches=2, update_epochs=2, hidden_size=16)


# ---------------------------------------------------------------- the simplex


def test_projection_by_hand():
    assert project_to_simplex(np.array([0.2, 0.3, 0.5]), 0.0) == pytest.approx([0.2, 0.3, 0.5])
    assert project_to_simplex(np.array([2.0, 0.0, 0.0]), 0.1) == pytest.approx([0.8, 0.1, 0.1])
    assert project_to_simplex(np.array([1.0, 0.8, -3.0]), 0.1) == pytest.approx([0.55, 0.35, 0.1])
    assert project_to_simplex(np.array([9.0, 1.0, -3.0]), 1 / 3) == pytest.approx([1 / 3] * 3)
    assert project_to_simplex(np.array([-7.0]), 0.5).tolist() == [1.0]


@pytest.mark.parametrize("least", [0.0, 1e-3, 0.019])
def test_nothing_allowed_is_nearer_than_the_projection(least):
    """The nearest point of a convex set: the angle to every other one of the set is at least a right one."""
    rng = np.random.default_rng(0)
    for spread in (0.01, 0.1, 3.0):
        point = rng.normal(0.02, spread, 50)
        nearest = project_to_simplex(point, least)
        assert nearest.sum() == pytest.approx(1) and nearest.min() >= least
        others = least + (1 - 50 * least) * rng.dirichlet(np.full(50, 0.3), 2_000)
        corners = least + (1 - 50 * least) * np.eye(50)
        assert ((np.concatenate([others, corners]) - nearest) @ (point - nearest)).max() < 1e-9


def test_numbers_that_cannot_be_so_large_are_refused():
    with pytest.raises(ValueError, match=r"3 numbers of at least 0\.5 add up to more than 1"):
        project_to_simplex(np.zeros(3), 0.5)
    for count in range(1, 200):  # the whole share, whatever the rounding
        assert project_to_simplex(np.arange(count), 1.0 / count) == pytest.approx(np.full(count, 1 / count))


def ascent(levels, **settings):
    made = SimplexAscent(NCCConfig(**settings))
    for _ in range(levels):
        made.add()
    return made


def test_levels_are_added_with_the_mean_of_the_others():
    made = ascent(4)
    assert made.y == pytest.approx([0.25] * 4)
    made.step(np.array([1.0, 0.0, 0.0, 0.0]))
    before = made.y / made.y[1]
    made.add()
    assert made.y.sum() == pytest.approx(1) and made.y[4] == pytest.approx(0.2)
    assert made.y[:4] / made.y[1] == pytest.approx(before)
    assert made.square[4] == pytest.approx(made.square[:4].mean())


@pytest.mark.slow
def test_the_ascent_of_fixed_scores_reaches_the_softmax():
    """E_y[score] + alpha H(y) is largest at y ~ exp(score / alpha)."""
    score = np.random.default_rng(1).uniform(0, 0.25, 20)
    made = ascent(20, ent_coef=0.1, floor=0.0, learning_rate=5.0)
    for _ in range(20_000):
        made.step(score)
    best = np.exp(score / 0.1)
    assert made.y == pytest.approx(best / best.sum(), rel=0.01)


def test_without_entropy_only_the_floor_keeps_the_others():
    made = ascent(5, ent_coef=0.0, floor=0.1)
    for _ in range(1_000):
        made.step(np.array([0.1, 0.0, 0.2, 0.1, 0.0]))
    assert made.y == pytest.approx([0.02, 0.02, 0.92, 0.02, 0.02])


# ---------------------------------------------------------------- the curriculum


def curriculum(**settings):
    config = NCCConfig(**{"capacity": 8, "episodes_per_level": 2, **settings})
    return NCCCurriculum(ThetaSpace(2), config, seed=0, budget=Budget(4))


def played(levels, records, learnable=()):
    """Give the curriculum results: levels with these ids are solved in one of two episodes, the others in both."""
    records["id"][records["id"] < 0] = levels.buffer.next_id + np.arange((records["id"] < 0).sum())
    records["returns"][:, 0] = 1.0
    records["returns"][np.isin(records["id"], learnable), 0, 1] = 0.0
    return levels.update(records)


def test_at_first_all_levels_are_random_and_learned_from():
    levels = curriculum(min_fill=0.5)
    records = levels.propose(3)
    assert records["train"].all() and (records["origin"] == Origin.RANDOM).all()
    assert "ncc/score" not in played(levels, records)  # no ascent yet
    played(levels, levels.propose(5))
    assert levels.buffer.weights() == pytest.approx(np.full(8, 1 / 8), abs=1e-9)
    assert (levels.propose(100)["origin"] == Origin.REPLAYED).any()


def test_what_is_drawn_follows_the_learned_distribution():
    levels = curriculum(candidate_share=0.0, rescore_share=0.0)
    played(levels, levels.propose(16)[:8], learnable=[3])
    for _ in range(20):
        levels.buffer.ascend()
    y = levels.buffer.weights()
    assert y.argmax() == 3 and y[3] > 0.3
    drawn = levels.propose(20_000)
    assert (drawn["origin"] == Origin.REPLAYED).all() and drawn["train"].all()
    share = np.bincount(levels.buffer.find(drawn["id"]), minlength=8) / len(drawn)
    assert share == pytest.approx(y, abs=0.015)


def test_the_shares_of_evaluated_levels():
    levels = curriculum(candidate_share=0.2, rescore_share=0.3)
    played(levels, levels.propose(16))
    records = levels.propose(10_000)
    random = records["origin"] == Origin.RANDOM
    assert not records["train"][random].any()
    assert random.mean() == pytest.approx(0.2, abs=0.02)
    assert (~records["train"] & ~random).mean() == pytest.approx(0.3, abs=0.02)


def test_the_oldest_scores_are_renewed_first():
    levels = curriculum(rescore_share=0.99, candidate_share=0.0)
    played(levels, levels.propose(16)[:8])
    assert levels.buffer.stalest(levels.dtype, 3)["id"].tolist() == [0, 1, 2]
    assert levels.buffer.stalest(levels.dtype, 6)["id"].tolist() == [3, 4, 5, 6, 7, 0]
    assert len(levels.buffer.stalest(levels.dtype, 20)) == 20  # more than there are


def test_a_better_candidate_replaces_the_level_of_the_lowest_score_and_gets_its_probability():
    levels = curriculum()
    played(levels, levels.propose(16)[:8], learnable=[0, 1, 2, 4, 5, 6, 7])
    for _ in range(10):
        levels.buffer.ascend()
    y = levels.buffer.weights().copy()
    candidate = levels._random(1)
    candidate["train"], candidate["id"] = False, 99
    candidate["returns"][:, 0] = [[0.0, 1.0]]
    candidate["score"] = 0.5
    assert levels.buffer.store(candidate)["buffer/inserted"] == 1
    assert levels.buffer.slots["id"].tolist() == [0, 1, 2, 99, 4, 5, 6, 7]
    assert (levels.buffer.weights() == y).all() and y.argmin() == 3


# ---------------------------------------------------------------- training


def frontier():
    return Frontier(16, longest=8, dim=3)


@pytest.mark.long
def test_all_steps_count_and_the_student_learns_from_levels_drawn_from_y():
    method, shares = NCC(frontier(), PPO, NCCConfig(capacity=24, episodes_per_level=2), seed=0, env_steps=40_000), []
    for update in range(60):
        metrics = method.update()
        assert metrics["env_steps"] == (update + 1) * 32 * 16 == method.env_steps
        shares.append(method.learner.rollout.train.float().mean().item())
        records = method.last.records
        drawn = records["train"] & (records["origin"] == Origin.REPLAYED)
        assert metrics["ncc/evaluated"] == (~records["train"]).sum()
        assert update < 30 or (records["train"] == drawn).all()
    assert shares[0] == 1.0 and 0.35 < np.mean(shares[30:]) < 0.65  # two simulated steps for each that is learned from
    assert len(method.buffer) == 24 and method.buffer.weights().sum() == pytest.approx(1)
    assert 1 <= metrics["ncc/levels"] <= 24


@pytest.mark.slow
def test_it_resumes_bit_for_bit():
    def made(seed):
        return NCC(frontier(), PPO, NCCConfig(capacity=24, score="mna"), seed=seed)

    one, other = made(0), made(1)
    for _ in range(12):
        one.update()
    other.load_state_dict(one.state_dict())
    for _ in range(8):
        found, same = one.update(), other.update()
        assert all(found[key] == same[key] or found[key] != found[key] for key in found if key[:5] != "time/")
        assert one.last.records.tobytes() == other.last.records.tobytes()
    assert one.buffer.weights().tobytes() == other.buffer.weights().tobytes()


def test_a_distribution_over_other_levels_is_refused():
    one, other = curriculum(), curriculum()
    played(one, one.propose(16)[:8])
    state = one.state_dict()
    state["buffer"]["ascent"]["y"] = np.full(3, 1 / 3)
    with pytest.raises(ValueError, match="y has 3 numbers for 8 levels"):
        other.load_state_dict(state)
