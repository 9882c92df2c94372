"""The picture of the rare levels shows each setting and order that has rows, and no others."""

import matplotlib.pyplot as plt
import pytest
from matplotlib.colors import to_hex

from lab import rare_levels_figure as figure
from regista.experiments.pictures import plots
from regista.experiments.pictures.variants import shades_of


def row(variant, order, seed, rare, shares=()):
    told = {f"rare_share_{k}": str(shares[k]) if k < len(shares) else "" for k in range(3)}
    return {"game": "1v1Rare", "variant": variant, "order": order, "seed": str(seed), "scene_0": str(rare)} | told


ROWS = [row("dr", "first", seed, 20 + seed) for seed in range(5)] + [
    row("paired", order, seed, 70, ("0.1", "0.5", "0.9")) for order in ("first", "last") for seed in range(2)
]


@pytest.fixture
def axes():
    drawn, axes = plt.subplots()
    yield axes
    plt.close(drawn)


def test_a_bar_for_each_setting_and_order_with_an_interval_where_there_are_five_runs(axes):
    figure.draw_success(axes, ROWS)
    assert [bar.get_height() for bar in axes.patches] == pytest.approx([0.22, 0.7, 0.7])
    assert len({bar.get_x() for bar in axes.patches}) == 3 and axes.get_ylim() == (0, 1)
    assert len(axes.lines) == 3 + 1  # the runs of each bar, and one interval
    assert [label.get_text() for label in axes.get_xticklabels()] == ["DR", plots.title("paired")]


def test_a_thin_line_for_each_run_that_proposed_levels_and_the_mean_of_each_setting(axes):
    more = [row(figure.ENTROPY, "first", seed, 70, (f"0.{seed}", "0.4", "0.4")) for seed in (2, 6)]
    figure.draw_shares(axes, ROWS + more, 3)
    thin, bold = axes.lines[:6], axes.lines[6:]
    assert list(thin[0].get_ydata()) == [0.1, 0.5, 0.9] and {line.get_color() for line in thin} == {plots.FAINT}
    assert [list(line.get_ydata()) for line in bold] == [pytest.approx(y) for y in ([0.1, 0.5, 0.9], [0.4, 0.4, 0.4])]
    assert bold[0].get_color() == plots.color("paired")
    assert min(line.get_linewidth() for line in bold) > 3 * max(line.get_linewidth() for line in thin)


@pytest.mark.slow
@pytest.mark.drawn
def test_it_is_drawn_for_several_games(tmp_path):
    others = [one | {"game": "1v1RareLine"} for one in ROWS]
    figure.draw([*ROWS, *others], 3, tmp_path / "rare.png")
    assert plt.imread(tmp_path / "rare.png").std() > 0.05


def test_settings_of_a_method_have_its_hue_and_hatches_of_their_own(axes):
    plots.distinguish(figure.VARIANTS)
    try:
        figure.draw_success(axes, [*ROWS[:5], *(row(figure.EVEN, "first", seed, 50) for seed in range(5))])
    finally:
        plots.distinguish({})
    own, even = axes.patches
    assert to_hex(own.get_facecolor()) == plots.color("dr") and own.get_hatch() is None
    assert to_hex(even.get_facecolor()) in shades_of(plots.color("dr")) and even.get_hatch()
