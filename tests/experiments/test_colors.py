"""Colors of methods and mazes: readers with a color vision deficiency tell them apart; no method has a team's color."""

import itertools

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from regista.envs.football.view import render
from regista.envs.maze import painter as maze
from regista.envs.maze import picture as mazes
from regista.experiments.pictures import plots
from regista.experiments.pictures.keys import method_handles
from regista.experiments.pictures.variants import shades_of

# Machado, Oliveira and Fernandes 2009, severity 1: linear RGB as it is seen, rows by channel.
DEFICIENCIES = {
    "none": np.eye(3),
    "protanopia": np.array([[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]),
    "deuteranopia": np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]),
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = np.array([0.9505, 1.0, 1.089])


METHODS_COLORS = {name: shade for name, shade in plots.METHOD_COLORS.items() if name not in plots.BASELINES}
SHADES = {name: shades_of(shade)[:3] for name, shade in METHODS_COLORS.items()}  # of variants, by method


def lab(colors, deficiency="none"):
    """Return colors `[n, 3]` in CIELAB, as they are seen: 2.3 is the least difference that is noticed."""
    rgb = np.array([to_rgb(color) for color in colors])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    share = np.clip(linear @ DEFICIENCIES[deficiency].T, 0, 1) @ TO_XYZ.T / WHITE
    f = np.where(share > 0.008856, np.cbrt(share), 7.787 * share + 16 / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], 1)


def contrast(color):
    """Return the contrast with white as WCAG defines it: from 1 to 21."""
    rgb = np.array(to_rgb(color))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return 1.05 / (linear @ TO_XYZ[1] + 0.05)


def closest(colors, deficiency):
    """Return the smallest distance between two of the colors."""
    return min(np.linalg.norm(one - other) for one, other in itertools.combinations(lab(colors, deficiency), 2))


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_methods_and_baselines_differ_for_every_reader(deficiency):
    baselines, methods = [plots.METHOD_COLORS[name] for name in plots.BASELINES], list(METHODS_COLORS.values())
    assert closest(methods, deficiency) > 20 and closest(baselines, deficiency) > 10
    apart = lab(methods, deficiency)[:, None] - lab(baselines, deficiency)[None]
    assert np.linalg.norm(apart, axis=2).min() > 20


def test_methods_are_dark_enough_on_white():
    assert min(map(contrast, METHODS_COLORS.values())) > 2.99
    assert min(contrast(shade) for shades in SHADES.values() for shade in shades) > 2.99


def test_methods_are_not_nearly_black():
    assert lab(METHODS_COLORS.values())[:, 0].min() > 25


def test_every_method_has_a_marker_of_its_own_which_many_curves_show():
    """In gray print, colors of the same lightness look alike."""
    markers = [plots.curve_look(name, plots.MANY)["marker"] for name in METHODS_COLORS]
    assert len(set(markers)) == len(METHODS_COLORS) and "marker" not in plots.curve_look("dr", plots.MANY - 1)
    handles = method_handles(METHODS_COLORS)
    assert [handle.get_marker() for handle in handles] == markers
    assert {handle.get_marker() for handle in method_handles(["dr", "paired"])} == {"None"}


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_variants_differ_for_every_reader(deficiency):
    assert min(closest([METHODS_COLORS[name], *shades], deficiency) for name, shades in SHADES.items()) > 10
    assert closest(plots.CYCLE, deficiency) > 10  # of what is no method


def test_variants_have_the_hue_of_their_method():
    """Their chroma is bounded, too: a gray has no hue."""
    for name, shades in SHADES.items():
        _, *own = lab([METHODS_COLORS[name]])[0]
        for _, *ab in lab(shades):
            cosine = np.dot(own, ab) / np.linalg.norm(own) / np.linalg.norm(ab)
            assert cosine > np.cos(np.radians(2)) and np.linalg.norm(ab) > 15, name


def test_no_method_has_the_color_of_a_team():
    teams = [*render.PAPER_COLORS[: render.BALL], *(np.array(shade) / 255 for _, shade, _ in render.MARKERS[:4])]
    shown = lab([*METHODS_COLORS.values(), *plots.CYCLE])
    assert np.linalg.norm(shown[:, None] - lab(teams)[None], axis=2).min() > 15


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_methods_differ_from_teams_on_paper_for_every_reader(deficiency):
    teams = lab(render.PAPER_COLORS[: render.BALL], deficiency)
    assert np.linalg.norm(lab(METHODS_COLORS.values(), deficiency)[:, None] - teams[None], axis=2).min() > 10


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_goal_agent_and_ground_of_mazes_differ_for_every_reader(deficiency):
    shown = [np.array(shade) / 255 for shade in (mazes.GOAL_COLOR, mazes.AGENT_COLOR)]
    assert closest(shown, deficiency) > 60  # densities are pale tints of both, one on the other
    frames = (mazes.WALL_COLOR, mazes.FLOOR, mazes.SEEN_FLOOR, mazes.SEEN_WALL)
    recordings = (maze.MazePainter.background, *(shade for _, shade, _ in maze.MARKERS[: maze.GOALS]))
    for grounds in (frames, recordings):
        apart = lab(shown, deficiency)[:, None] - lab([np.array(shade) / 255 for shade in grounds], deficiency)[None]
        assert np.linalg.norm(apart, axis=2).min() > 25


def test_mazes_have_the_same_colors_everywhere_and_no_method_has_them():
    markers = {name: shade for name, shade, _ in maze.MARKERS}
    assert (markers["goal"], markers["agent"]) == (mazes.GOAL_COLOR, mazes.AGENT_COLOR)
    assert markers["seen cells"] == mazes.SEEN_FLOOR
    shown = lab([np.array(shade) / 255 for shade in (mazes.GOAL_COLOR, mazes.AGENT_COLOR)])
    assert np.linalg.norm(lab([*METHODS_COLORS.values(), *plots.CYCLE])[:, None] - shown[None], axis=2).min() > 15


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_what_is_compared_with_differs_from_ink_for_every_reader(deficiency):
    assert closest([plots.REFERENCE, plots.INK], deficiency) > 20


def test_a_methods_color_does_not_depend_on_what_is_compared():
    before = {name: plots.color(name) for name in plots.METHOD_COLORS}
    variants = {f"{method} {k}": method for k in range(3) for method in ("dr", "paired")}
    plots.distinguish(variants)
    try:
        assert {name: plots.color(name) for name in plots.METHOD_COLORS} == before
        assert {plots.line_style(name) for name in before} == {"-"}
        assert not any("hatch" in plots.bar_look(name) for name in before)
        for method in ("dr", "paired"):
            mine = [name for name, known in variants.items() if known == method]
            assert [plots.color(name) for name in mine] == SHADES[method]
            assert len({plots.line_style(name) for name in mine} | {"-"}) == 4
            assert len({plots.bar_look(name)["hatch"] for name in mine}) == 3
    finally:
        plots.distinguish({})
