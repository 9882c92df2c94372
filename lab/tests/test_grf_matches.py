"""The family `matches`: counts in whole matches."""

import numpy as np
import pytest

from lab.grf import matches
from lab.grf.report import read_data
from lab.grf.stage import Trace


def test_passes_turnovers_and_restarts_are_counted():
    steps = 40
    owner = np.full((steps, 1), -1)
    owner[5:10], owner[15:20], owner[30:35] = 3, 4, 14
    ball = np.zeros((steps, 1, 3))
    ball[12:, 0, 0] = 20.0
    mode = np.zeros((steps, 1), int)
    mode[36:39] = 5
    blank = np.zeros((steps, 1, 22, 2))
    trace = Trace(ball, ball, blank, blank, owner, mode, np.zeros((steps, 1, 2)), np.zeros((steps, 1)))
    found = matches.events(trace)
    assert found["passes left"] == 1 and found["turnovers won right"] == 1
    assert found["pass length median"] == pytest.approx(20.0)
    assert matches.restarts(trace)["throw-ins"] == 1
    assert matches.possession(trace)["possession left"] == pytest.approx(10 / 15)


@pytest.mark.long
def test_whole_matches_give_every_quantity_and_players_run_as_far_as_measured():
    rows = matches.measure(0.1)
    assert {row.name.split(": ")[1] for row in rows} == {row["quantity"] for row in read_data("matches")}
    ways = [row for row in rows if "run by an outfield player" in row.name]
    assert len(ways) == 2 and all(row.ok for row in ways), ways
