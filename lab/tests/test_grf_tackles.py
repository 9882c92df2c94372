"""The tackles' family of comparisons with Google Research Football: its measurements at low effort."""

import pytest

from lab.grf import tackles
from lab.grf.tackles import measure, run_past, slide_in, stand_up

pytestmark = pytest.mark.drawn


def test_who_stands_loses_the_ball_and_a_sprinter_is_not_caught():
    assert stand_up("stands", "front", 20) > 0.9
    assert stand_up("sprints", "behind", 20) == 0.0


def test_slides_win_from_the_front_and_foul_from_the_side():
    front, side = slide_in("stands", "front", 1.5, 40), slide_in("stands", "side", 1.5, 40)
    assert front.won > 0.7 and front.foul < 0.2
    assert side.foul > 0.8 and side.yellow > 0.8
    assert slide_in("stands", "front", 6.0, 10).won == 0.0


@pytest.mark.slow
def test_a_lone_defender_behind_a_sprinter_is_too_late():
    lost, scored, _ = run_past("sprints", -3.0, 0.0, 10)
    assert lost < 0.2 and scored > 0.7


@pytest.mark.long
def test_the_family_is_drawn(tmp_path):
    tackles.figure(tmp_path / "tackles.png", 0.1)
    assert (tmp_path / "tackles.png").stat().st_size > 1000
    assert len(measure(0.1)) == 55
