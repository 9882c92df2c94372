"""What figures of comparisons show is in the tables: single values, every period of training, values of choices."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.view.render import FootballPainter
from regista.experiments.pictures import curves, level_plots, plots, theta_plots
from regista.experiments.pictures import overview as pictures
from regista.experiments.run.games import find_minigame
from regista.experiments.run.programs import load_program
from regista.experiments.run.table import Table
from ued.core.parameters import Choice, Column, Integer, LogRange, Range

pytestmark = pytest.mark.drawn
THETA = [f"theta/{d}" for d in range(6)]


def test_a_run_with_a_single_evaluation_is_a_dot(tmp_path):
    rows = {"long": range(1, 9), "short": [3], "other": [3]}
    for name, updates in rows.items():
        (tmp_path / name).mkdir()
        table = [{"update": k, "env_steps": 1000 * k + 7 * len(name), "eval/easy": 0.5} for k in updates]
        Table(tmp_path / name / "metrics.csv").append(table)
    figure = curves.learning_figure({"dr": [tmp_path / "long", tmp_path / "short"], "plr": [tmp_path / "other"]})
    dots = [line for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert len(dots) == 3 and {line.get_color() for line in dots} == {plots.color("dr"), plots.color("plr")}
    shown = [np.asarray(line.get_xdata())[np.isfinite(line.get_ydata())] for line in dots]
    assert all(len(places) and np.allclose(places, 3035, atol=50) for places in shown)
    assert figure.axes[0].get_ylim()[0] == 0


def write_metrics(folder, rows):
    folder.mkdir()
    Table(folder / "metrics.csv").append(rows)
    return folder


@pytest.mark.parametrize("count", [3, curves.FEW - 1, curves.FEW, 60])
def test_curves_of_few_values_have_a_marker_at_each(tmp_path, count):
    """Runs are evaluated at slightly different steps; their mean has one marker for both."""
    rows = [
        [{"update": k, "env_steps": 1000 * k + apart, "eval/easy": k % 3} for k in range(count)] for apart in (0, 4)
    ]
    runs = [write_metrics(tmp_path / str(k), mine) for k, mine in enumerate(rows)]
    axes = curves.learning_figure({"dr": runs}).axes[0]
    *thin, mean = axes.lines
    assert {line.get_marker() for line in thin} == {""}
    if count >= curves.FEW:
        assert mean.get_marker() == "None"
        return
    marked = np.array(mean.get_xydata())[mean.get_markevery()]
    assert mean.get_marker() == "o" and np.allclose(marked[:, 0], 1000 * np.arange(count), atol=5)
    assert np.allclose(marked[1:-1, 1], np.arange(count)[1:-1] % 3, atol=0.01)  # not off the corners


def test_many_methods_have_the_markers_of_the_legend(tmp_path):
    rows = [{"update": k, "env_steps": k, "eval/easy": k} for k in range(99)]
    runs = {name: [write_metrics(tmp_path / name, rows)] for name in ("dr", "paired", "plr", "accel", "sfl")}
    figure = curves.learning_figure(runs)
    shown = [line.get_marker() for line in figure.axes[0].lines]
    assert shown == [plots.MARKERS[name] for name in runs]
    assert [handle.get_marker() for handle in figure.legends[0].legend_handles] == shown


def test_values_of_few_episodes_are_pooled_with_their_neighbors(tmp_path):
    """The first update finished one level, which is solved; the last one finished few, too."""
    counts, success = [1, 9, 30, 40, 5], [1.0, 0.0, 0.2, 0.5, 1.0]
    rows = [
        {"update": k, "env_steps": 10 * k, "levels": n, "success": y, "return/a": y, "episodes/a": 100}
        for k, (n, y) in enumerate(zip(counts, success, strict=True), 1)
    ]
    panels = curves._panels({"dr": [write_metrics(tmp_path / "run", rows)]})
    curve = panels["success on training levels"].curves[0][1]
    assert curve.steps.tolist() == [30, 50] and curve.values[0] == pytest.approx([7 / 40, 25 / 45])
    assert panels["return on training levels"].curves[0][1].values[0].tolist() == success  # of 100 episodes each
    few = curves.pooled(np.array([1.0, 2.0]), np.array([1.0, 0.0]), np.array([1.0, 3.0]))
    assert [values.tolist() for values in few] == [[2.0], [0.25]]


def test_no_period_of_training_is_shown_twice():
    (rows,) = pictures._level_rows({"paired": [Path("a")]})
    assert [title for title, _, _ in rows] == [f"PAIRED, {name}" for name in ("all of training", *level_plots.PERIODS)]
    assert [span for *_, span in rows] == [(0.0, 1.0), *level_plots.PERIODS.values()]
    for name in ("a variant with a very long name " * 3, "another_name_of_one_word" * 4):
        lines = pictures._shortened(f"{name.strip()}, last tenth", 30).splitlines()
        assert lines[1] == "last tenth" and len(lines) == 2 and max(map(len, lines)) <= 31
    assert pictures._shortened("PAIRED, middle", 30) == "PAIRED, middle"


@pytest.mark.slow
def test_titles_of_levels_do_not_overlap(tmp_path, monkeypatch):
    Table(tmp_path / "levels.csv").append([{"update": k} | dict.fromkeys(THETA, k / 9) for k in range(1, 9)])
    painter = FootballPainter(Lineup(load_program(find_minigame("1v1Restricted").program, 2)))
    found = []
    monkeypatch.setattr(plots, "save", lambda figure, path: found.append(figure))
    level_plots.levels(
        {"another_rather_long_variant_name_without_spaces": [tmp_path]}, painter, tmp_path / "levels.png"
    )
    found[0].canvas.draw()
    extents = [axes._left_title.get_window_extent() for axes in found[0].axes[:3]]
    assert not any(one.overlaps(other) for one, other in itertools.combinations(extents, 2))


@pytest.mark.slow
def test_choices_have_a_bar_for_each_value_beside_its_weight(tmp_path, monkeypatch):
    draws = [
        Column("ground", Choice("ice", "mud", weights=(3, 1))),
        Column("x", Range(0, 1)),
        Column("legs", Integer(1, 2)),
    ]
    rows = [{"update": 1 + k // 4, "theta/ground": -0.25, "theta/x": 0.9, "theta/legs": -0.5} for k in range(40)]
    Table(tmp_path / "levels.csv").append(rows)
    found = []
    monkeypatch.setattr(plots, "save", lambda figure, path: found.append(figure))
    theta_plots.levels({"dr": [tmp_path]}, tmp_path / "levels.png", draws)
    ground, x, legs = found[0].axes
    shares = [[patch.get_data().values.tolist() for patch in axes.patches] for axes in (ground, legs)]
    assert shares == [[[1.0, 0.0]] * 3 + [[0.75, 0.25]], [[1.0, 0.0]] * 3 + [[0.5, 0.5]]]
    assert [label.get_text() for label in (*ground.get_xticklabels(), *legs.get_xticklabels())] == [
        "ice",
        "mud",
        "1",
        "2",
    ]
    assert x.patches[-1].get_data().values.tolist() == [1 / 20] * 20 and x.patches[0].get_data().values[19] == 1.0
    wide = [{"update": 1} | {f"theta/p{d}": 0.0 for d in range(40)}]
    (tmp_path / "wide").mkdir()
    Table(tmp_path / "wide" / "levels.csv").append(wide)
    theta_plots.levels({"dr": [tmp_path / "wide"]}, tmp_path / "levels.png")
    assert found[1].legends[0].get_title().get_text() == "levels of (the first 8 of 40 parameters)"


@pytest.mark.slow
def test_numbers_label_the_axes_of_levels_in_their_own_units(tmp_path, monkeypatch):
    kinds = {"length": LogRange(0.1, 4), "push": Range(2, 15), "narrow": LogRange(1, 4), "steps": Integer(0, 100)}
    draws = [*(Column(name, kind) for name, kind in kinds.items()), Column("free", Range(0, 0))]
    Table(tmp_path / "levels.csv").append([{"update": 1} | {f"theta/{draw.name}": 0.0 for draw in draws}])
    found = []
    monkeypatch.setattr(plots, "save", lambda figure, path: found.append(figure))
    theta_plots.levels({"dr": [tmp_path], "plr": [tmp_path]}, tmp_path / "levels.png", draws)
    above, below = found[0].axes[:5], found[0].axes[5:]
    for axes, other in zip(above[:4], below, strict=False):
        assert list(axes.get_xticks()) == list(other.get_xticks())
    for axes, kind in zip(below, kinds.values(), strict=False):
        labels = [float(label.get_text()) for label in axes.get_xticklabels()]
        assert 2 <= len(labels) <= 6 and min(labels) >= kind.low and max(labels) <= kind.high
        known = [kind.to_unit(value) for value in labels]
        assert np.allclose(axes.get_xticks(), known, atol=0.03) and axes.get_xlabel() == "value"
    assert [label.get_text() for label in below[0].get_xticklabels()] == ["0.1", "0.2", "0.5", "1", "2"]
    assert below[4].get_xlabel() == "θ (lowest to highest value)"  # a single value has no scale
