"""The keeper's family of comparisons with Google Research Football: its measurements at low effort."""

import numpy as np
import pytest

from lab.grf import keeper
from lab.grf.keeper import cross_line, fit_odds, measure, random_shots

pytestmark = pytest.mark.drawn


def test_a_free_ball_is_followed_to_the_line():
    """A ball 10 m away at 30 m/s along the diagonal arrives after a little more than a third of a second, at 1 m."""
    y, height, time = cross_line(np.array([[45.0, 5.0, 0.11]]), np.array([[30.0, -15.0, 4.0]]))[0]
    assert y == pytest.approx(0.0, abs=0.1)
    assert 0.6 < height < 1.2
    assert time == pytest.approx(0.36, abs=0.03)
    assert cross_line(np.array([[45.0, 0.0, 0.11]]), np.array([[-5.0, 0.0, 0.0]]))[0, 2] == 9.0


def test_the_logistic_fit_finds_the_law_that_made_the_data():
    rng = np.random.default_rng(0)
    features = np.column_stack([np.ones(4000), rng.uniform(-1, 1, (4000, 2))])
    law = np.array([0.5, -2.0, 1.0])
    happened = rng.uniform(size=4000) < 1.0 / (1.0 + np.exp(-features @ law))
    assert fit_odds(features, happened) == pytest.approx(law, abs=0.25)


@pytest.mark.slow
def test_near_and_wide_shots_score_and_far_ones_at_him_do_not():
    shots = random_shots(600)
    quick = shots.on_target & (shots.time < 0.4) & (shots.gap > 1.2)
    straight = shots.on_target & (shots.time > 0.5) & (shots.gap < 1.0)
    assert quick.sum() > 20 and straight.sum() > 15
    assert shots.goal[quick].mean() > 0.55
    assert shots.goal[straight].mean() < 0.3


@pytest.mark.slow
def test_the_family_is_drawn(tmp_path):
    keeper.figure(tmp_path / "keeper.png", 0.05)
    assert (tmp_path / "keeper.png").stat().st_size > 1000
    assert len(measure(0.05)) == 31
