"""Pictures are drawn, are not blank, and show every method."""

import itertools
from pathlib import Path
from types import SimpleNamespace

import matplotlib.image
import numpy as np
import pytest

from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.view.render import NOSE, FootballPainter, pitch_lines
from regista.experiments.pictures import curves, keys, level_plots, plots
from regista.experiments.pictures import overview as pictures
from regista.experiments.pictures.overview import Comparison, overview
from regista.experiments.run.games import find_minigame
from regista.experiments.run.programs import load_program
from regista.experiments.run.results import Result
from regista.experiments.run.table import Table
from ued.core.task import TRAINING_SCENE
from ued.methods import METHODS

pytestmark = pytest.mark.drawn


@pytest.fixture(scope="module")
def painter():
    program = load_program(find_minigame("1v1Restricted").program, 2)
    return FootballPainter(Lineup(program))


@pytest.fixture
def runs(tmp_path, painter):
    """Return two made-up runs of each method."""
    rng = np.random.default_rng(0)
    found = {}
    for method in ("dr", "paired"):
        for seed in range(2):
            run = tmp_path / f"{method}-{seed}"
            run.mkdir()
            metrics, levels = Table(run / "metrics.csv"), Table(run / "levels.csv")
            for update in range(1, 61):
                row = {"update": update, "env_steps": 4096 * update, "return/student": update / 60 + rng.normal(0, 0.1)}
                if update % 10 == 1:
                    row |= {f"eval/{scene}": update / 80 + rng.normal(0, 0.05) for scene in SCENES}
                if method == "paired":
                    row["regret"] = 0.3 + rng.normal(0, 0.05)
                metrics.append([row])
                theta = rng.uniform(-1, 1, (5, 6))
                levels.append(
                    [{"update": update} | {f"theta/{d}": value for d, value in enumerate(row)} for row in theta]
                )
            found.setdefault(method, []).append(run)
    return found


SCENES = (TRAINING_SCENE, "easy", "hard")


def ink(path):
    """Return the share of a picture's pixels that are not white."""
    image = matplotlib.image.imread(path)[..., :3]
    assert min(image.shape[:2]) > 200
    return float((image < 0.99).any(-1).mean())


def has_color(path, color):
    from matplotlib.colors import to_rgb

    image = matplotlib.image.imread(path)[..., :3]
    return bool((np.abs(image - to_rgb(color)).max(-1) < 0.02).any())


@pytest.mark.long
def test_learning_curves(runs, tmp_path):
    path = tmp_path / "curves.png"
    curves.learning_curves(runs, path)
    assert 0.01 < ink(path) < 0.5
    assert has_color(path, plots.METHOD_COLORS["dr"]) and has_color(path, plots.METHOD_COLORS["paired"])


@pytest.mark.long
def test_levels(runs, painter, tmp_path):
    path = tmp_path / "levels.png"
    level_plots.levels(runs, painter, path)
    assert ink(path) > 0.3


class Dots:
    """Draws the first four columns of θ as two points on a stage of half a meter."""

    bounds = reach = (-0.25, 0.25, -0.25, 0.25)
    background, line_color, focus = (20, 20, 20), (250, 250, 250), 0
    markers = (("me", (200, 40, 200), 0.1), ("goal", (0, 150, 0), 0.1))
    classes = np.array([0, 1])

    def lines(self):
        return [np.array([[-0.25, -0.25], [0.25, 0.25]])]

    def positions(self, theta):
        return theta[:, :4].reshape(-1, 2, 2) / 4


@pytest.mark.long
def test_levels_of_other_painters_have_the_colors_and_names_of_their_markers(runs, tmp_path):
    import matplotlib.pyplot as plt

    path = tmp_path / "levels.png"
    level_plots.levels(runs, Dots(), path)
    assert ink(path) > 0.1 and not has_color(path, "#1f77d0")
    figure = plt.figure()
    level_plots.draw_scales(figure, Dots())
    assert [axes.get_title() for axes in figure.axes] == ["me", "goal"]
    for axes, (_, shade, _) in zip(figure.axes, Dots.markers, strict=True):
        (scale,) = axes.images
        colors = scale.get_array()[0]  # from no opacity to that of the highest density
        assert np.round(255 * colors[-1, :3]).tolist() == list(shade) and colors[0, 3] == 0
        assert (np.diff(colors[:, 3]) > 0).all() and colors[-1, 3] == pytest.approx(keys.OPACITY)
    plt.close(figure)


def test_the_density_of_keepers_alone_has_their_color(painter):
    from regista.envs.football.view.render import LEFT_KEEPER, PAPER_COLORS, RIGHT_KEEPER, RIGHT_PLAYER

    for opponents, first in (((RIGHT_KEEPER,), RIGHT_KEEPER), ((RIGHT_KEEPER, RIGHT_PLAYER), RIGHT_PLAYER)):
        shown = SimpleNamespace(markers=painter.markers, classes=np.array([0, LEFT_KEEPER, *opponents]))
        (_, mine, blue), (_, theirs, shade) = level_plots.kinds_of(shown)
        assert blue == PAPER_COLORS[0] and mine.tolist()[:2] == [True, False] and not mine[2:].any()
        assert shade == PAPER_COLORS[first] and theirs.tolist() == [False, False, *[True] * len(opponents)]


class Squares(Dots):
    """Draws two walls as squares of 0.25 m, and `Dots` between them."""

    markers = (*Dots.markers, ("walls", (100, 100, 100), 0.125))
    classes = np.array([0, 1, 2, 2])
    tiles = classes == 2

    def positions(self, theta):
        walls = np.broadcast_to([[-0.125, -0.125], [0.125, -0.125]], (len(theta), 2, 2))
        return np.concatenate([super().positions(theta), walls], 1)


def test_densities_on_a_grid_are_not_mixed():
    import matplotlib.pyplot as plt

    theta = np.array([[-0.5, -0.5, 0.5, 0.5], [-0.5, 0.5, 0.5, 0.5]])  # me in two cells, the goal in one
    figure, axes = plt.subplots()
    level_plots.draw_levels(axes, Squares(), [theta])
    (image,) = axes.images
    pixels, half = image.get_array(), level_plots.CELL_PIXELS
    assert image.origin == "lower" and pixels.shape == (2 * half, 2 * half, 3)

    def seen(row, column, share):
        """Return the color of a cell, at a share of its width."""
        return pixels[row * half + half // 2, column * half + int(share * half)].tolist()

    def shade(kind):
        return pytest.approx((1 - keys.OPACITY * (1 - np.array(Squares.markers[kind][1]) / 255)).tolist())

    assert all(seen(row, 0, 0.3) == shade(0) for row in range(2)) and seen(1, 1, 0.7) == shade(1)
    assert all(seen(row, column, 0.3) == [1, 1, 1] for row, column in ((0, 1), (1, 1)))
    assert all(seen(0, column, 0.01) == shade(2) and seen(1, column, 0.01) == [1, 1, 1] for column in (0, 1))
    plt.close(figure)


@pytest.mark.long
def test_overview(runs, painter, tmp_path):
    results = [
        Result(method, seed, scene, 100, 0.5, 0.5, 50 + 10 * seed, 30.0, 1000, 10)
        for method, seed in (("dr", 0), ("dr", 1), ("paired", 0), ("paired", 1), ("shoot", 0))
        for scene in SCENES
    ]
    results += [Result("random", 0, scene, 50, 0.0, 0.0, 0, 30.0, 0, 0) for scene in SCENES]  # 0 %: no bar below 0
    path = tmp_path / "overview.png"
    overview(Comparison("1v1Restricted", runs, results, painter), path)
    assert ink(path) > 0.2
    assert all(has_color(path, plots.METHOD_COLORS[method]) for method in ("dr", "paired", "shoot"))


@pytest.mark.slow
@pytest.mark.drawn
@pytest.mark.parametrize("evaluated", [True, False])
def test_without_evaluations_in_training_there_is_no_panel_of_them(runs, painter, monkeypatch, tmp_path, evaluated):

    drawn, long = [], "PAIRED-with-a-name-that-is-long"
    monkeypatch.setattr(plots, "save", lambda figure, path: drawn.append(figure))
    if not evaluated:
        monkeypatch.setattr(pictures.curves, "read_curve", lambda paths, column: None)
    results = [
        Result(name, seed, "easy", 100, 0.5, 0.5, 50, 30.0, 1000, 10) for name in ("dr", long) for seed in (0, 1)
    ]
    renamed = {"dr": runs["dr"], long: runs["paired"]}
    pictures.overview(Comparison("a game", renamed, results, painter), tmp_path / "overview.png")
    above, below = drawn[0].subfigs
    titles = [axes.get_title("left") for axes in above.axes]
    assert titles == [*["Return on the training distribution"] * evaluated, "Goals after training, share of episodes"]
    legend = [text.get_text() for text in above.legends[0].get_texts()]
    assert (keys.MEAN in legend) == (keys.RANGE in legend) == evaluated
    drawn[0].canvas.draw()
    boxes = [axes._left_title.get_window_extent() for axes in below.axes[: pictures.COLUMNS]]
    assert below.axes[1].get_title("left").replace("\n", " ").endswith("first tenth")
    gap = drawn[0].dpi * 0.2
    assert all(one.x1 + gap < other.x0 for one, other in itertools.pairwise(boxes))


def test_a_bar_without_results_is_absent(runs, painter):
    import matplotlib.pyplot as plt

    results = [Result("dr", 0, "easy", 100, 0.5, 0.5, 50, 30.0, 1000, 10)]
    results += [Result("paired", 0, scene, 100, 0.5, 0.5, 50, 30.0, 1000, 10) for scene in ("easy", "hard")]
    figure, axes = plt.subplots()
    pictures._draw_goals(axes, Comparison("a game", runs, results, painter))
    assert len(axes.patches) == 3 and all(bar.get_height() == 0.5 for bar in axes.patches)
    assert axes.get_ylim() == (0, 1)
    plt.close(figure)


@pytest.mark.slow
def test_the_mean_of_all_scenes_stands_first_and_differences_to_the_first_method_below_the_heading(runs, painter):
    import matplotlib.pyplot as plt

    goals = {"dr": (20, 22, 24, 26, 28), "paired": (60, 62, 64, 66, 68), "plr": (5, 15, 24, 33, 43)}
    results = [
        Result(method, seed, scene, 100, 0.5, 0.5, count + extra, 30.0, 1000, 10)
        for method, counts in goals.items()
        for seed, count in enumerate(counts)
        for scene, extra in (("easy", 10), ("hard", 0), ("harder", -2))
    ]
    known = Comparison("a game", dict.fromkeys(goals, [Path()] * 5), results, painter)
    [line] = pictures._gains(known)
    assert line.startswith("Goals on all scenes minus domain randomization, points [95% CI]: PAIRED +40 [")
    assert "] *; PLR +0 [" in line and line.endswith("no difference detected")
    figure, axes = plt.subplots()
    pictures._draw_goals(axes, known)
    names = [label.get_text() for label in axes.get_xticklabels()]
    heights = {round(bar.get_x() + bar.get_width() / 2, 3): bar.get_height() for bar in axes.patches}
    assert names == ["all scenes", "easy", "hard", "harder"] and len(heights) == 12
    assert [round(height, 4) for at, height in sorted(heights.items()) if at < 0.5] == [0.2667, 0.6667, 0.2667]
    plt.close(figure)
    single = Comparison("a game", {"dr": [Path()], "paired": [Path()]}, results[:3] + results[15:18], painter)
    assert pictures._gains(single) == []  # one run each: no interval


@pytest.mark.slow
def test_curves_begin_at_zero_rates_end_at_one_and_legends_say_what_is_drawn(runs):
    for run in itertools.chain.from_iterable(runs.values()):
        table = run / "metrics.csv"
        lines = table.read_text().splitlines()
        table.write_text("\n".join([f"{lines[0]},success", *(f"{line},0.25" for line in lines[1:])]) + "\n")
    figure = curves.learning_figure(runs)
    axes = {axes.get_title(loc="left"): axes for axes in figure.axes}
    assert axes["success on training levels"].get_ylim() == (0, 1)
    assert all(panel.get_xlim()[0] == 0 for panel in figure.axes if panel.get_visible())
    assert axes["regret of training levels"].get_ylim()[0] == 0
    for panel in figure.axes:
        means = [line for line in panel.lines if line.get_linewidth() == 2.0]
        assert all(line.zorder > spine.zorder for line in means for spine in panel.spines.values())
    said = [text.get_text() for text in figure.legends[0].texts]
    assert said == ["domain randomization", "PAIRED", *keys.RUNS]
    alone = curves.learning_figure({method: paths[:1] for method, paths in runs.items()})
    assert len(alone.legends[0].texts) == 2  # without bands, nothing explains them


@pytest.mark.slow
def test_titles_lie_within_the_picture_and_beside_each_other(runs):
    for run in runs["dr"]:
        table = run / "metrics.csv"
        table.write_text(table.read_text().replace("eval/hard", f"eval/{'a scene with a long name ' * 4}"))
    figure = curves.learning_figure(runs)
    figure.canvas.draw()
    boxes = [axes.title if not axes.get_title(loc="left") else axes._left_title for axes in figure.axes]
    extents = [title.get_window_extent() for title in boxes if title.get_text()]
    assert len(extents) >= 5 and max(len(title.get_text().splitlines()) for title in boxes) > 1
    assert all(box.x0 >= 0 and box.x1 <= figure.bbox.x1 and box.y1 <= figure.bbox.y1 for box in extents)
    assert not any(one.overlaps(other) for one, other in itertools.combinations(extents, 2))


@pytest.mark.long
@pytest.mark.parametrize("kind", plots.FORMATS)
def test_pictures_of_every_format(runs, tmp_path, kind):
    path = tmp_path / f"curves.{kind}"
    curves.learning_curves(runs, path)
    first = path.read_bytes()
    assert first.startswith({"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[kind])
    if kind == "svg":
        assert b"PAIRED" in first and plots.METHOD_COLORS["paired"].encode() in first  # text, not outlines
        assert b"'DejaVu Sans', 'Verdana', 'Arial', sans-serif" in first
    if kind != "png":
        curves.learning_curves(runs, path)
        assert path.read_bytes() == first
    if kind == "pdf":
        assert b"/Type3" not in first


def test_a_format_replaces_the_ending_of_a_picture():
    found = [str(plots.in_format(Path(name), kind)) for name, kind in (("a.png", None), ("a.pdf", None), ("a", None))]
    assert found == ["a.png", "a.pdf", "a.png"]
    assert str(plots.in_format(Path("a.png"), "svg")) == "a.svg"
    assert str(plots.in_format(Path("a.b"), "svg")) == "a.b.svg"


def test_a_curve_averages_runs_on_one_axis(runs):
    curve = curves.read_curve(runs["dr"], "return/student", points=50)
    assert curve.values.shape == (2, 50)
    assert curve.steps[0] == 4096 and curve.steps[-1] == 60 * 4096
    assert np.isfinite(curve.values).all()
    assert curves.read_curve(runs["dr"], "regret") is None


def test_levels_of_a_period_are_those_of_its_updates(runs):
    assert len(level_plots.read_periods(runs["dr"][0], [(0.0, 1.0)])[0]) == 300
    assert len(level_plots.read_periods(runs["dr"][0], [(0.9, 1.0)])[0]) == 30
    levels = runs["dr"][1] / "levels.csv"
    levels.write_text(levels.read_text().splitlines()[0] + "\n")  # no level was finished
    assert level_plots.read_periods(runs["dr"][1], [(0.0, 0.1)])[0].shape == (0, 6)


def test_the_pitch_lies_within_its_measures():
    points = np.concatenate(pitch_lines())
    assert np.abs(points[:, 0]).max() == pytest.approx(55.0 + 2.2)
    assert np.abs(points[:, 1]).max() == pytest.approx(36.0)


def test_the_painter_puts_players_and_ball_in_metres(painter):
    positions = painter.positions(np.zeros((1, 6)))[0]
    assert painter.classes.tolist().count(4) == 1  # one ball, the last point
    ego = positions[painter.focus]
    assert ego == pytest.approx((50 * 0.544, 0.0))
    assert positions[-1] == pytest.approx((50 * 0.544, 2.0 * 0.836 + 0.1 * 0.836), abs=0.2)
    assert painter.bounds[0] == -3.0  # the right half: only the own keeper stands on the left


def test_a_short_run_has_levels_in_all_periods(tmp_path):
    Table(tmp_path / "levels.csv").append([{"update": update, "theta/0": update / 10} for update in range(1, 7)])
    thetas = level_plots.read_periods(tmp_path, level_plots.PERIODS.values())
    found = {name: theta[:, 0].tolist() for name, theta in zip(level_plots.PERIODS, thetas, strict=True)}
    assert found == {"first tenth": [0.1], "middle": [0.3, 0.4], "last tenth": [0.6]}


def test_every_method_has_a_color_and_a_name_of_its_own():
    for known in (plots.METHOD_COLORS, plots.METHOD_NAMES):
        assert set(METHODS) <= set(known) and len(set(known.values())) == len(known)


def test_curves_of_students_whatever_their_names(tmp_path):
    """A population has no protagonist: its first student is the one that is evaluated."""
    run = tmp_path / "paired-0"
    run.mkdir()
    rows = [{"update": k, "env_steps": k, "return/student0": 1.0, "return/student1": 0.0} for k in range(1, 9)]
    Table(run / "metrics.csv").append(rows)
    (panel,) = curves._panels({"paired": [run]}).values()
    assert panel.curves[0][1].values.tolist() == [[1.0] * 8]


def test_several_runs_are_one_recording(runs, tmp_path):
    pytest.importorskip("rerun")
    from rerun.chunk import RrdReader

    from regista.experiments.pictures.runs_recording import record_runs
    from regista.experiments.run.table import read_columns

    record_runs(runs, tmp_path / "all.rrd")
    reader = RrdReader(str(tmp_path / "all.rrd"))
    assert len(reader.recordings()) == 1 and len(reader.blueprints()) == 1
    found = {}
    for chunk in reader.stream().filter(content="/metrics/return/student/**"):
        if not chunk.is_static:
            rows = chunk.to_record_batch()
            values = zip(rows.column("env_steps").to_pylist(), rows.column("Scalars:scalars").to_pylist(), strict=True)
            found[str(chunk.entity_path).rpartition("/")[2]] = {steps: value for steps, (value,) in values}
    assert set(found) == {"dr-0", "dr-1", "paired-0", "paired-1"}
    table = read_columns(runs["paired"][1] / "metrics.csv")
    assert found["paired-1"] == dict(zip(table["env_steps"], table["return/student"], strict=True))


def test_of_a_long_run_evenly_spaced_levels_are_drawn(runs, monkeypatch):
    monkeypatch.setattr(level_plots, "MOST_LEVELS", 40)
    run = runs["dr"][0]
    whole, half = level_plots.read_periods(run, [(0.0, 1.0), (0.5, 1.0)])
    monkeypatch.undo()
    every, second = level_plots.read_periods(run, [(0.0, 1.0), (0.5, 1.0)])
    assert len(every) == 300 and len(second) > 140
    np.testing.assert_array_equal(whole, every[::8])
    np.testing.assert_array_equal(half, second[::4])


def test_headings_of_players_are_drawn(painter):
    import matplotlib.pyplot as plt

    theta = np.zeros((1, 6))
    figure, axes = plt.subplots()
    painter.draw(axes, theta)
    places, lines = painter.positions(theta)[0], [line.get_xydata() for line in axes.lines]
    for place in places[:-1]:  # of players, not of the ball
        (heading,) = [line for line in lines if len(line) == 2 and np.allclose(line[0], place)]
        assert np.linalg.norm(heading[1] - heading[0]) == pytest.approx(NOSE, rel=1e-3)
    plt.close(figure)
