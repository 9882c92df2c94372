"""`Program.theta`, the inverse of `instantiate`: round trips, hand-made scenes, and what cannot be met."""

from pathlib import Path

import numpy as np
import pytest
from scene import described, things

from regista.envs.football.scenic.domain import FOOTBALL
from regista.minigames.suites import MINIGAMES
from scenic_lite import ScenicError, load

ROOT = Path(__file__).parents[2]
FIGURES = sorted((ROOT / "tests" / "programs").glob("*.scenic"))
MINIGAME_FILES = sorted({game.program for game in MINIGAMES.values()})
OPEN = ROOT / "tests" / "oracle" / "open"
CONTINUOUS = ("range", "normal", "point.x", "point.y", "point.along")
N = 32

# Each draws with a different kind of expression between θ and the scene.
PROGRAMS = {
    "nested range": "a = new Thing at Range(0, Range(5, 9)) @ 0",
    "a shared draw": "x = Range(0, 5)\na = new Thing at x @ 2 * x\nb = new Thing at (x - 1) @ (3 / (x + 1))",
    "normal values": "a = new Thing at Normal(3, 2) @ TruncatedNormal(0, 1, -1, 2)",
    "choices": "a = new Thing at Uniform(1, 5, 9) @ Discrete({1: 2, 4: 1}), with kind Uniform('x', 'y')",
    "integers": "a = new Thing at DiscreteRange(-3, 12) @ -DiscreteRange(1, 6)",
    "a rotated rectangle": "r = RectangularRegion(3 @ 4, 30 deg, 10, 4)\na = new Thing in r",
    "a disc and a sector": "a = new Thing in CircularRegion(1 @ 2, 5)\nb = new Thing in SectorRegion(0 @ 0, 9, 0.3, 1)",
    "a polygon": "a = new Thing in PolygonalRegion([(0, 0), (9, 0), (9, 3), (3, 3), (3, 8), (0, 8)])",
    "a polyline": "a = new Thing on PolylineRegion([(0, 0), (9, 0), (9, 7)])",
    "points": "a = new Thing in PointSetRegion('spots', [(0, 0), (9, 0), (9, 7)])",
    "a random heading": "a = new Thing facing Range(0, 90) deg\nb = new Thing left of a by Range(1, 3)",
    "a polar offset": "a = new Thing offset by Range(-3, 3) @ Range(2, 5), facing Range(-1, 1)",
    "what several draws decide": "u = Range(0, 1)\nv = Range(0, 2)\na = new Thing at (u + v) @ (u - 2 * v)",
    "bent functions": "a = new Thing at abs(Range(1, 5)) @ sin(Range(0, 1)), with speed Range(1, 3) ** 2",
    "a chosen object": "a = new Thing at 9 @ 9\nb = new Thing with friend Uniform(ego, a)",
    "params": "param day = Range(1, 30)\nparam weather = Uniform('sun', 'rain')",
    "arguments": "behavior Walk(speed, to):\n    wait\nr = RectangularRegion(3 @ 4, 0, 2, 4)\n"
    "a = new Thing with behavior Walk(Range(1, 5), Point on r)",
    "noise on a fixed place": "a = new Thing at 3 @ 4, facing 30 deg\nmutate a by 2",
    "noise on a random place": "a = new Thing at Range(0, 9) @ Normal(0, 1)\nb = new Thing left of a by 2\nmutate a, b",
    "a fixed range": "a = new Thing at Range(4, 4) @ Range(1, 2)",
}

AMBIGUOUS = {"nested range", "points", "noise on a random place"}  # many θ give the same scene


def assert_round_trip(program):
    theta = np.random.default_rng(0).uniform(-1, 1, (N, program.dim))
    scenes = program.instantiate(theta)
    found = np.isfinite(scenes.positions).all(axis=(1, 2))
    theta, scenes = theta[found], program.instantiate(theta[found])
    arguments = {
        draw.name: [program.describe(row)[draw.name] for row in theta]
        for draw in program.draws
        if ".behavior." in draw.name
    }
    back = program.theta(described(scenes) | arguments, default=np.zeros(program.dim))
    again = program.instantiate(back)
    np.testing.assert_allclose(again.positions, scenes.positions, atol=1e-6)
    np.testing.assert_allclose(again.headings, scenes.headings, atol=1e-6)
    assert repr(again.params) == repr(scenes.params) or np.allclose(*map(numbers, (again.params, scenes.params)))
    known = [d for d, draw in enumerate(program.draws) if draw.kind in CONTINUOUS and draw.low != draw.high]
    return np.abs(back - theta)[:, known].max(initial=0.0)


def numbers(params):
    return np.array([value for value in params.values() if np.asarray(value).dtype.kind == "f"])


@pytest.mark.parametrize("path", [*FIGURES, *MINIGAME_FILES], ids=lambda path: path.stem)
def test_scenes_of_football_lead_back_to_their_theta(path):
    assert assert_round_trip(load(path, FOOTBALL)) < 1e-9


@pytest.mark.parametrize("name", PROGRAMS)
def test_scenes_lead_back_to_their_theta(name):
    away = assert_round_trip(things(PROGRAMS[name]))
    assert away < 1e-9 or name in AMBIGUOUS


@pytest.mark.long
@pytest.mark.parametrize("dialect", [2, 3])
def test_scenes_of_programs_from_elsewhere_lead_back(dialect):
    tried = 0
    for path in sorted(OPEN.glob("*.scenic")):
        try:
            program = load(path, dialect=dialect)
        except ScenicError:  # of the other dialect, or meant to be refused
            continue
        assert_round_trip(program)
        tried += 1
    assert tried > 30


@pytest.mark.slow
def test_many_turned_objects_are_found_without_a_search():
    program = things("\n".join(["new Thing in CircularRegion(0 @ 0, 9), facing Range(0, 360) deg"] * 30), 3)
    assert assert_round_trip(program) < 1e-9


@pytest.fixture
def figure():
    return load(ROOT / "tests/programs/figure_4_3.scenic", FOOTBALL)


def test_a_hand_made_scene_becomes_a_level(figure):
    theta = figure.theta({"ego": (30, 5), "opponent": (70, 0), "MyGK": (-99, 0)})
    scenes = figure.instantiate(theta)
    np.testing.assert_allclose(scenes.positions[0, :2], [(30, 5), (70, 0)], atol=1e-9)
    np.testing.assert_allclose(theta[0], [-0.25, 0.2, 0.75, 0, -1 / 3, 0], atol=1e-9)


def test_an_object_that_others_follow_is_enough(figure):
    theta = figure.theta({"ball": (30, 7.1)}, default=np.zeros(6))
    np.testing.assert_allclose(figure.instantiate(theta).positions[0, 0], (30, 5), atol=1e-9)


def test_arrays_describe_many_scenes(figure):
    places = np.array([[10, 5], [20, -5], [30, 0]])
    theta = figure.theta({"ego": places, 1: (np.array([50, 60, 70]), 3)}, default=np.zeros(6))
    scenes = figure.instantiate(theta)
    np.testing.assert_allclose(scenes.positions[:, 0], places, atol=1e-9)
    np.testing.assert_allclose(scenes.positions[:, 1], [(50, 3), (60, 3), (70, 3)], atol=1e-9)


def test_params_draws_and_properties_are_asked_for_by_name():
    program = things(
        "behavior Walk(speed):\n    wait\nx = Range(0, 4)\nparam day = Range(1, 30)\n"
        "a = new Thing at x @ 0, with color Uniform('red', 'blue'), with behavior Walk(Range(1, 5))"
    )
    asked = {"x": 3, "day": 12.5, "a": {"color": "blue"}, "a.behavior.speed": 2}
    scenes = program.instantiate(program.theta(asked))
    assert scenes.positions[0, 1, 0] == pytest.approx(3)
    assert scenes.params["day"][0] == pytest.approx(12.5)
    assert scenes.properties["color"][1][0] == "blue"
    assert scenes.behavior_arguments[1]["speed"][0] == pytest.approx(2)


def test_a_heading_may_be_a_turn_away():
    program = things("a = new Thing at 3 @ Range(0, 1), facing Range(-90, 90) deg", 3)
    theta = program.theta({"a": (3, 0.5, 2 * np.pi + 0.5)})
    assert program.instantiate(theta).headings[0, 1] == pytest.approx(0.5)


def test_draws_of_one_sum_are_found_together():
    program = things("a = new Thing at (Range(0, 1) + Range(0, 1)) @ 0")
    theta = program.theta({"a": (1.9, 0)})
    assert program.instantiate(theta).positions[0, 1, 0] == pytest.approx(1.9)


ERRORS = [
    ({"ego": (30, 5)}, "the description of the scene does not determine X2 (line 3), Y2 (line 4)", 3),
    ({"ego": (98, 5)}, "found no θ that gives ego the position (98 @ 5) (the nearest that was found is (80 @ 5))", 6),
    ({"MyGK": (0, 0)}, "found no θ that gives MyGK the position (0 @ 0) (the nearest that was found is (-98 @ 0))", 9),
    ({"ball": (30, 5), "ego": (30, 0)}, "found no θ that gives ball the position (30 @ 5)", 10),
    ({"ego": {"heading": 1}}, "found no θ that gives ego the heading 1 (the program fixes it at 0)", 6),
    ({"ego": (np.array([3, 98]), 5)}, "found no θ that gives ego the position (98 @ 5) in scene 1", 6),
    ({"keeper": (3, 4)}, "has no object, parameter or draw 'keeper'", None),
    ({9: (3, 4)}, "has no object, parameter or draw 9", None),
    ({"ego": {"wdth": 2}}, "ego has no property 'wdth' (did you mean 'width'?)", 6),
    ({"ego": 3}, "ego takes (x, y) or (x, y, heading), not 3", 6),
    ({"ego": ("far", 3)}, "ego the position cannot be ('far', 3)", 6),
    ({"ego": (float("nan"), 3)}, "ego the position cannot be a number that is not finite", 6),
    ({"ego": (np.zeros(2), 3), 1: (np.zeros(3), 0)}, "have different lengths: 2 and 3", None),
]


@pytest.mark.parametrize(("asked", "message", "line"), ERRORS, ids=[str(asked) for asked, _, _ in ERRORS])
def test_what_cannot_be_met_is_said(figure, asked, message, line):
    default = None if "does not determine" in message else np.zeros(6)
    with pytest.raises(ScenicError) as caught:
        figure.theta(asked, default=default)
    assert message in str(caught.value)
    assert (caught.value.place.line if caught.value.place else None) == line


def test_no_scenes_are_no_levels(figure):
    assert figure.theta({"ego": np.zeros((0, 2))}, default=np.zeros(6)).shape == (0, 6)


def test_a_default_has_one_row_or_one_for_each_scene(figure):
    assert figure.theta({}, default=np.zeros(6)).shape == (1, 6)
    with pytest.raises(ValueError, match="default must be one row of theta or 1 of them, not 2"):
        figure.theta({"ego": (3, 4)}, default=np.zeros((2, 6)))
    with pytest.raises(ValueError, match=r"of the shape \[N, 6\]"):
        figure.theta({"ego": (3, 4)}, default=np.zeros(5))


def test_scenes_are_described(figure):
    with pytest.raises(TypeError, match="scenes are described like"):
        figure.theta(figure.instantiate(np.zeros((1, 6))))


@pytest.mark.parametrize(
    "text",
    [
        "speed = Range(5, 10)\nparam speed = speed + 1\na = new Thing at 0 @ 0, with kind speed",
        "x = Range(0, 1)\ny = Range(2, 3)\nparam x = y\nparam y = x\na = new Thing at x @ y",
        "x = Range(0, 1)\nx = Range(x, 2)\nparam x = x\na = new Thing at x @ 0",
        "t = Uniform(0 @ 0, 5 @ 5)\na = new Thing at t",
        "t = Uniform((1, 2), (3, 4), (5, 6))\na = new Thing at t[0] @ 0",
        "t = Uniform(None, 3)\na = new Thing at 0 @ 0, with kind t",
        "t = Uniform('1', 1)\na = new Thing at 0 @ 0, with kind t",
        "a = new Thing at 9 @ 9\nb = new Thing at 0 @ 0\nt = Uniform(a, b)\nc = new Thing at 20 @ 20, with friend t",
    ],
)
def test_theta_is_the_inverse_of_describe(text):
    """Also where a parameter has the name of a draw, and where options are no numbers."""
    program = things(text)
    for theta in np.random.default_rng(0).uniform(-1, 1, (8, program.dim)):
        values = program.describe(theta)
        assert program.describe(program.theta(values)[0]) == pytest.approx(values)


def test_an_option_that_does_not_exist_is_answered_with_those_that_do():
    program = things("t = Uniform(0 @ 0, 5 @ 5)\na = new Thing at t")
    (_, title) = program.draws[0].options
    assert program.theta({"t": [title, title]}).shape == (2, 1) and program.theta({"t": 1}).shape == (1, 1)
    with pytest.raises(ScenicError, match="t cannot be 'elsewhere'"):
        program.theta({"t": "elsewhere"})
