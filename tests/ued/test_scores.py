"""Scores by hand: negative returns, episodes that are missing, and what a trainer has to tell."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from ued.core.level_space import level_dtype
from ued.levels.record import level_record_dtype, make_records
from ued.levels.scores import fields, population_regret, regret, score

GAP = np.nan


def records(returns, **values):
    made = make_records(level_record_dtype(level_dtype(1), 1, len(returns[0])), np.zeros(len(returns), level_dtype(1)))
    made["returns"][:, 0] = returns
    for name, column in values.items():
        made[name][:, 0] = column
    return made


def test_max_mc_is_the_best_ever_minus_what_was_expected():
    levels = records([[-1.0, -0.5], [1.0, GAP]], mean_value=[[-0.8, -0.6], [0.25, GAP]])
    assert score("max_mc", levels) == pytest.approx([-0.5 + 0.7, 0.75])  # no maximum that starts at 0
    assert score("max_mc", levels, best=np.array([2.0, -3.0])) == pytest.approx([2.7, 0.75])
    assert score("max_mc", levels, best=np.array([np.nan, np.nan])) == pytest.approx([0.2, 0.75])


def test_value_losses_are_means_over_the_episodes_that_were_played():
    levels = records([[0.0, 0.0], [0.0, GAP]], positive_advantage=[[0.2, 0.4], [0.5, GAP]])
    assert score("positive_value_loss", levels) == pytest.approx([0.3, 0.5])
    levels = records([[0.0, 0.0], [0.0, GAP]], absolute_advantage=[[0.6, 0.4], [0.7, GAP]])
    assert score("l1_value_loss", levels) == pytest.approx([0.5, 0.7])


def test_learnability_is_the_variance_of_success_without_bias():
    assert score("learnability", records([[1.0, 0.0], [1.0, 1.0], [-1.0, 0.0]])) == pytest.approx([0.5, 0.0, 0.0])
    assert score("learnability", records([[1.0, -1.0, 0.0, 2.0]])) == pytest.approx([1 / 3])
    assert score("learnability", records([[1.0, -1.0, GAP, GAP]])) == pytest.approx([0.5])
    held = records([[0.0, -1.0], [0.0, 0.0], [0.0, -1.0]], success=[[1.0, 0.0], [1.0, 1.0], [GAP, GAP]])
    assert score("learnability", held) == pytest.approx([0.5, 0.0, 0.0])  # the environment's word before the return's
    rng = np.random.default_rng(0)
    for count in (2, 5):
        learnability = score("learnability", records((rng.random((40_000, count)) < 0.3).astype(float)))
        assert learnability.mean() == pytest.approx(0.3 * 0.7, abs=0.003)


def test_generalized_learnability_by_hand():
    levels = records([[1.0, 3.0], [6.0, 6.0], [2.0, 6.0], [1.0, GAP]])
    near = [np.exp(-0.5 * (mean - 3.25) ** 2 / np.var([2, 6, 4, 1])) for mean in (2, 4)]
    assert score("generalized_learnability", levels) == pytest.approx([2**0.5 * near[0], 0, 8**0.5 * near[1], 0])
    assert score("generalized_learnability", records([[-5.0, -3.0]])) == pytest.approx([2**0.5])  # no other level


def test_generalized_learnability_depends_on_no_unit():
    rng = np.random.default_rng(0)
    returns = rng.normal(size=(20, 1)) + rng.normal(size=(20, 5))
    one, other = (score("generalized_learnability", records(each)) for each in (returns, 7 * returns - 300))
    assert other == pytest.approx(7 * one)


def test_mna_is_the_mean_sum_on_levels_that_were_solved_once():
    dtype = level_record_dtype(level_dtype(1), 1, 2, fields("mna", 2))
    levels = make_records(dtype, np.zeros(3, level_dtype(1)))
    levels["returns"][:, 0] = [[0.0, 0.0], [0.0, GAP], [1.0, 0.0]]
    with pytest.raises(ValueError, match=r'the score mna needs records\["negative_advantage"\]'):
        score("mna", levels)
    levels["negative_advantage"][:, 0], levels["ever_solved"] = [[2.0, 4.0], [5.0, GAP], [1.0, 1.5]], [0, 1, 1]
    assert score("mna", levels) == pytest.approx([0.0, 5.0, 1.25])


def test_a_level_without_an_episode_is_not_scored_zero():
    with pytest.raises(ValueError, match="level 1 has no finished episode, so it has no score"):
        score("learnability", records([[1.0, 0.0], [GAP, GAP]]))


def test_a_score_that_needs_values_says_so():
    with pytest.raises(ValueError) as error:
        score("max_mc", records([[1.0]]))
    assert str(error.value) == (
        'the score max_mc needs records["mean_value"], which the trainer has not filled in; '
        "the score learnability needs only returns"
    )


def test_regret_of_episodes_that_are_missing():
    protagonist, antagonist = np.array([[-1.0, GAP]]), np.array([[0.0, 1.0]])
    assert regret(protagonist, antagonist, "max_mean").tolist() == [2.0]
    assert regret(protagonist, antagonist, "mean_mean").tolist() == [1.5]


def test_population_regret_by_hand():
    returns = np.array([[[0.0, 1.0], [-1.0, -1.0], [0.0, 0.0]]])  # one level, three students, two episodes
    mean = (0.5 - 1.0 + 0.0) / 3
    assert population_regret(returns, "max_mean") == pytest.approx([1.0 - mean])
    assert population_regret(returns, "mean_mean") == pytest.approx([0.5 - mean])


def test_with_equal_students_max_minus_mean_measures_chance():
    """E[max of n - mean] of outcomes 0 and 1 is 1 - (1 - p)^n - p."""
    rng, p, n = np.random.default_rng(0), 0.3, 4
    one, other = ((rng.random((60_000, n)) < p).astype(float) for _ in range(2))
    assert regret(one, other, "max_mean").mean() == pytest.approx(1 - (1 - p) ** n - p, abs=0.01)
    assert regret(one, other, "mean_mean").mean() == pytest.approx(0.0, abs=0.01)


def mean_regret(role, p, rule, episodes=2):
    """Return the exact mean regret of two students who both succeed with probability p in each episode."""
    outcomes = np.array(list(itertools.product((0.0, 1.0), repeat=2 * episodes)))  # [2^(2 n), 2 n]
    chance = np.where(outcomes == 1, p, 1 - p).prod(1)
    returns = outcomes.reshape(-1, 2, episodes)
    if role == "population":
        return float(chance @ population_regret(returns, rule))
    return float(chance @ regret(returns[:, 0], returns[:, 1], rule, flexible=role == "flexible"))


@pytest.mark.parametrize("role", ["dennis2020", "flexible", "population"])
def test_the_page_of_methods_has_the_bias_of_each_role(role):
    """Of two equal students at p = 0.1, 0.5 and 0.9, with the default two episodes for each level."""
    page = (Path(__file__).parents[2] / "docs" / "methods.md").read_text()
    row = next(line for line in page.splitlines() if line.startswith(f"| `{role}`"))
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    for cell, rule in zip(cells[-3:-1], ("max_mean", "mean_mean"), strict=True):
        assert [float(value) for value in cell.split(", ")] == [
            pytest.approx(mean_regret(role, p, rule), abs=0.0051) for p in (0.1, 0.5, 0.9)
        ]
