"""What is told of an adversary: its proposals by column beside the program's weights, and options that it neglects."""

import numpy as np
import pytest

from regista.experiments.pictures.level_plots import choices_of, draw_proposals
from regista.experiments.run.errors import CommandError
from regista.experiments.run.events import NEGLECT_UPDATES, Watch
from regista.experiments.run.proposals import read_proposals, render_proposals
from regista.experiments.run.table import Table
from ued.core.parameters import Choice, Column, Range
from ued.core.upomdp import level_dtype
from ued.levels.diagnostics import choice_metrics
from ued.levels.record import Origin, level_record_dtype, make_records

DRAWS = (Column("side", Choice("left", "in the way", "right", weights=(25, 1, 25))), Column("x", Range(0, 10)))


def write(path, middle, source="proposed"):
    """Write the levels of 20 updates, 10 each; from the second half on they have the option in the middle."""
    path.mkdir()
    update = np.repeat(np.arange(1, 21), 10)
    theta = np.where(update > 10, middle, -0.5)
    columns = {"update": update, "source": np.full(200, source), "theta/side": theta, "theta/x": np.full(200, 0.95)}
    Table(path / "levels.csv").append_columns(columns | {"score": np.where(theta == 0, 0.9, 0.3)})
    return path


@pytest.mark.slow
@pytest.mark.parametrize("columns", [1, 32])
def test_proposals_stand_beside_the_weights_of_the_program(tmp_path, monkeypatch, columns):
    monkeypatch.setattr("regista.experiments.run.proposals.AT_ONCE", columns)
    run = write(tmp_path / "run", 0.0)
    side, x = read_proposals(run, DRAWS)
    assert side.names == ("left", "in the way", "right") and side.choice and not x.choice
    assert side.program == pytest.approx(np.array([25, 1, 25]) / 51)
    assert side.proposed[0].tolist() == [1, 0, 0] and side.proposed[-1].tolist() == [0, 1, 0]
    assert side.score[:2].tolist() == pytest.approx([0.3, 0.9]) and np.isnan(side.score[2])
    assert x.names[-1] == "9 to 10" and (x.proposed[:, -1] == 1).all() and x.program[-1] == pytest.approx(0.1)
    text = render_proposals(run, [side, x])
    assert "in the way  2.0%     0.0%" in text and "nan" not in text
    draw_proposals([side, x], tmp_path / "columns.png")
    assert (tmp_path / "columns.png").exists()
    assert [column.title for column in choices_of([run], DRAWS)] == ["side"]


def test_a_run_without_an_adversary_is_told(tmp_path):
    run = write(tmp_path / "dr", 0.0, "random")
    with pytest.raises(CommandError, match="has no levels proposed by an adversary"):
        read_proposals(run, DRAWS)
    assert choices_of([run], DRAWS) == []


def test_metrics_tell_how_often_an_option_is_proposed_and_what_it_scores():
    levels = np.zeros(100, level_dtype(2))
    levels["theta"][:, 0] = np.where(np.arange(100) < 2, 0.0, 0.5)
    records = make_records(level_record_dtype(level_dtype(2)), levels, Origin.PROPOSED)
    records["score"] = np.where(levels["theta"][:, 0] == 0, 0.8, 0.2)
    metrics = choice_metrics(records, DRAWS)
    assert metrics["choice_ratio/side/in the way"] == pytest.approx(0.02 * 51)
    assert metrics["choice_ratio/side/left"] == 0.0 and np.isnan(metrics["choice_score/side/left"])
    assert metrics["choice_score/side/in the way"] == pytest.approx(0.8)


def events(ratio, score):
    """Return what is told of 60 updates in which the option in the middle is proposed so often, and scores so much."""
    watch, told = Watch(), []
    for _ in range(2 * NEGLECT_UPDATES):
        row = {f"choice_{kind}/side/{name}": 1.0 for kind in ("ratio", "score") for name in ("left", "right")}
        row |= {"choice_ratio/side/in the way": ratio, "choice_score/side/in the way": score}
        told += watch.look({"update": 1, **row})
    return [event.event for event in told], told


def test_an_option_of_high_score_that_is_hardly_proposed_is_an_event():
    kinds, told = events(0.5, 3.0)
    assert kinds == ["neglected option"]
    assert told[0].text.startswith(
        "side/in the way has a score of 3.00, the mean option 1.67, but is proposed 0.50 times"
    )
    assert events(1.2, 3.0)[0] == [] and events(0.5, 1.0)[0] == []
