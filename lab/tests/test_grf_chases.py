"""The family of backs and chasers: its measurements."""

import numpy as np
import pytest

from lab.grf import chases

pytestmark = pytest.mark.drawn


def test_places_are_those_of_episodes_that_go_on_for_so_long():
    chase = next(chase for chase in chases.chases() if chase.number == 100)
    ours = chase.play()
    assert chases.mean_places(ours, 0).shape == (1, 2)
    places = ours.places[:, 8, chases.FIRST :].mean(0)
    np.testing.assert_allclose(chases.mean_places(ours, 8), places)
    ours.lengths[: 1 - chases.LEAST] = 7
    assert np.isnan(chases.mean_places(ours, 8)).all()


@pytest.mark.slow
@pytest.mark.long
def test_backs_and_chasers_run_where_the_original_s_run():
    rows = chases.measure()
    assert len(rows) == 8
    assert all(row.ok for row in rows), [(row.name, row.ours) for row in rows if not row.ok]


@pytest.mark.long
def test_the_family_is_drawn(tmp_path):
    chases.figure(tmp_path / "chases.png", 0.1)
    assert (tmp_path / "chases.png").stat().st_size > 1000
