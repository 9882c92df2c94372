"""The families of passes and shots: properties that hold at low effort."""

import numpy as np
import pytest

from lab.grf import passes, shots


@pytest.mark.parametrize(("kind", "distance", "speed", "flight"), [("short", 10.0, 15.0, 7), ("high", 15.0, 14.7, 15)])
def test_a_pass_is_as_fast_as_measured_and_arrives_in_time(kind, distance, speed, flight):
    trace = passes.straight_pass(kind, distance, 4)
    start = passes.first_moving(trace)
    ours = np.linalg.norm(trace.ball_velocity[start, np.arange(4), :2], axis=-1)
    assert ours == pytest.approx(np.full(4, speed), rel=0.05)
    assert passes.reception(trace, start).mean() == pytest.approx(flight, abs=1.5)


@pytest.mark.parametrize(
    ("direction", "mate"), [("right", 0), ("top_right", 1), ("top", 2), ("left", 3), ("bottom", 4)]
)
def test_a_pass_goes_to_the_mate_of_the_original_when_it_does(direction, mate):
    chosen, delay = passes.choice("short", direction, 3)
    assert (chosen == mate).all() and 3.0 <= delay <= 7.0


def test_a_pass_that_nobody_takes_has_no_reception():
    trace = passes.straight_pass("high", 40.0, 2)
    assert (passes.reception(trace, passes.first_moving(trace)) > 40).all()


def test_a_shot_straight_ahead_is_straight_and_a_charged_one_later_and_harder():
    short, long = (shots.shoot((0.8, 0.0), "right", 1, presses, 8) for presses in (1, 4))
    assert abs(np.mean(short.line_y)) < 0.01 and np.std(short.line_y) < 0.01
    assert short.delay == pytest.approx(3.0, abs=0.5) and long.delay == pytest.approx(6.0, abs=0.5)
    assert long.speed > short.speed + 1.0


def test_a_shot_with_keys_to_the_side_goes_that_way_as_far_as_measured():
    up, down = (shots.shoot((0.65, 0.0), key, 1, 1, 12) for key in ("top_right", "bottom_right"))
    assert np.mean(up.line_y) == pytest.approx(-0.048, abs=0.015)
    assert np.mean(down.line_y) == pytest.approx(0.048, abs=0.015)
