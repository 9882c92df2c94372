"""Figures of the lab: shared colors, and legends that fit and name all drawn curves."""

import re

import numpy as np
import pytest

from lab.benchmarks import scale
from lab.grf import figures
from lab.grf.figures import GRF, OURS, Panel, draw_panels
from regista.experiments.pictures import plots

pytestmark = pytest.mark.drawn


@pytest.fixture
def drawn(monkeypatch):
    """Return the figures, which are recorded instead of saved."""
    found = []
    for module in (figures, plots):
        monkeypatch.setattr(module, "save", lambda figure, path: found.append(figure))
    return found


def test_both_simulators_have_the_shared_colors_and_a_legend(drawn, tmp_path):
    x = np.arange(3)
    lines, points = (
        Panel("a curve", (x, x), (x, x + 1), up="m"),
        Panel("rates", (x, x / 2), (x, x / 3), up="share", points=True),
    )
    draw_panels(tmp_path / "panels.png", "a family", [lines, points])
    (figure,) = drawn
    assert [text.get_text() for text in figure.legends[0].texts] == [GRF, OURS, GRF, OURS]
    for axes in figure.axes:
        assert [line.get_color() for line in axes.lines] == [plots.REFERENCE, plots.INK]
    assert figure.axes[1].get_ylim() == (0, 1) and figure.axes[1].yaxis.get_major_formatter()(0.5) == "50%"
    draw_panels(tmp_path / "panels.png", "a family", [lines])
    assert [text.get_text() for text in drawn[1].legends[0].texts] == [GRF, OURS]


@pytest.mark.slow
def test_the_figure_of_scale_names_methods_in_their_colors(drawn, tmp_path):
    points = [scale.Point(panel, "1v1Free", x, 10.0 * x) for panel in scale.PANELS for x in (1, 2)]
    points += [scale.Point("columns", name, x, 10.0 * x) for name in ("dr", "plr", "accel", "paired") for x in (1, 2)]
    scale.draw([point for point in points if (point.panel, point.curve) != ("columns", "1v1Free")], tmp_path)
    (figure,) = drawn
    axes = next(axes for axes in figure.axes if axes.get_title(loc="left") == scale.PANELS["columns"].title)
    assert [line.get_label() for line in axes.lines] == ["domain randomization", "PLR", "ACCEL", "PAIRED"]
    assert axes.lines[3].get_color() == plots.METHOD_COLORS["paired"]
    figure.canvas.draw()
    labels = [label.get_text() for axes in figure.axes for label in (*axes.get_xticklabels(), *axes.get_yticklabels())]
    assert labels and all(re.fullmatch(r"\d+(\.\d+)?[kMG]?", label) for label in labels), labels
    legends = [axes.get_legend().get_window_extent() for axes in figure.axes]
    assert max(box.x1 for box in legends) <= figure.bbox.x1
    assert not any(one.overlaps(other) for one in legends for other in legends if one is not other)
