"""Each distribution against its own cumulative distribution function, over uniform θ and at the corners of θ."""

import math
from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from scene import things

from scenic_lite import ScenicError, load

N = 20_000
LIMIT = 1.95 / math.sqrt(N)  # Kolmogorov's distance, exceeded once in a thousand
RNG = np.random.default_rng


def normal(mean, spread):
    return np.vectorize(NormalDist(mean, spread).cdf)


def truncated(mean, spread, low, high):
    cdf = NormalDist(mean, spread).cdf
    return np.vectorize(lambda x: (cdf(min(max(x, low), high)) - cdf(low)) / (cdf(high) - cdf(low)))


CONTINUOUS = [
    ("Range(2, 7)", lambda x: (x - 2) / 5),
    ("Range(-15, -25)", lambda x: (x + 25) / 10),
    ("Normal(3, 2)", normal(3, 2)),
    ("TruncatedNormal(0, 1, -0.5, 2)", truncated(0, 1, -0.5, 2)),
    ("Range(0, 1) ** 2", np.sqrt),
    ("abs(Range(-1, 1))", lambda x: x),
    ("Range(0, Range(0, 1))", lambda x: x - x * np.log(x)),
    ("max(Range(0, 1), Range(0, 1))", lambda x: x**2),
]
DISCRETE = [
    ("DiscreteRange(1, 6)", dict.fromkeys(range(1, 7), 1 / 6)),
    ("DiscreteRange(-1.5, 1.2)", {-1: 1 / 3, 0: 1 / 3, 1: 1 / 3}),
    ("Uniform(1, 5, 9)", {1: 1 / 3, 5: 1 / 3, 9: 1 / 3}),
    ("Uniform('pass', 'shoot')", {"pass": 0.5, "shoot": 0.5}),
    ("Discrete({10: 1, 20: 3, 30: 6, 40: 0})", {10: 0.1, 20: 0.3, 30: 0.6}),
    ("Discrete({'a': 2, 'b': 8})", {"a": 0.2, "b": 0.8}),
    ("Uniform(*[1, 2])", {1: 0.5, 2: 0.5}),
    ("str(DiscreteRange(1, 2))", {"1": 0.5, "2": 0.5}),
    ("f'no. {DiscreteRange(1, 2)}'", {"no. 1": 0.5, "no. 2": 0.5}),
    ("Uniform(1, 2) + Uniform(1, 2)", {2: 0.25, 3: 0.5, 4: 0.25}),
    ("Uniform((1, 2), (3, 5))[1]", {2: 0.5, 5: 0.5}),
    ("int(Range(0, 3))", {0: 1 / 3, 1: 1 / 3, 2: 1 / 3}),
    ("round(Range(0, 2))", {0: 0.25, 1: 0.5, 2: 0.25}),
]


def values(text, seed=0):
    program = things(f"param value = {text}")
    return program.instantiate(RNG(seed).uniform(-1, 1, (N, program.dim))).params["value"]


@pytest.mark.parametrize(("text", "cdf"), CONTINUOUS)
def test_continuous(text, cdf):
    ordered = np.sort(values(text))
    assert np.abs(cdf(ordered) - (np.arange(N) + 0.5) / N).max() < LIMIT


@pytest.mark.parametrize(("text", "shares"), DISCRETE)
def test_discrete(text, shares):
    found = values(text)
    assert set(found) == set(shares)
    for value, share in shares.items():
        assert abs(np.mean(found == value) - share) < 5 * math.sqrt(share * (1 - share) / N)


@pytest.mark.parametrize(("text", "_"), CONTINUOUS + DISCRETE)
def test_corners_of_theta_have_values(text, _):
    program = things(f"param value = {text}")
    corners = np.array([np.full(program.dim, sign) for sign in (-1.0, 1.0)])
    scenes = program.instantiate(corners)
    assert scenes.ok.all()
    if scenes.params["value"].dtype.kind == "f":
        assert np.isfinite(scenes.params["value"]).all()


def test_median_is_in_the_middle_of_theta():
    program = things("param value = Normal(3, 2)")
    np.testing.assert_allclose(program.instantiate(np.zeros((1, 1))).params["value"], 3, atol=1e-12)


def test_a_name_used_twice_is_one_column():
    program = things("x = Range(0, 1)\nparam a = x\nparam b = x + 1")
    scenes = program.instantiate(RNG(0).uniform(-1, 1, (50, 1)))
    np.testing.assert_array_equal(scenes.params["a"] + 1, scenes.params["b"])


def test_each_evaluation_draws_anew():
    program = things("def draw():\n    return Range(0, 1)\nparam values = [draw() for i in range(3)]")
    assert program.dim == 3


def test_resample_is_independent():
    program = things("x = Normal(0, 1)\ny = resample(x)\nparam x = x\nparam y = y")
    scenes = program.instantiate(RNG(0).uniform(-1, 1, (N, 2)))
    assert abs(np.corrcoef(scenes.params["x"], scenes.params["y"])[0, 1]) < 0.03
    assert abs(scenes.params["y"].std() - 1) < 0.03


def test_unused_draws_get_no_column():
    program = things("unused = Range(0, 1)\nalso = [Uniform(1, 2), unused]\nparam x = Range(3, 4)")
    assert [draw.name for draw in program.draws] == ["x"]


def test_draws_tell_name_kind_limits_and_place():
    text = (
        "ego = Object at Range(1, 2) @ 3, with requireVisible False\n"
        "spot = Point in CircularRegion(0 @ 0, 5)\n"
        "n = Normal(0, 1)\n"
        "which = Uniform(ego, spot)\n"
        "param a = (spot.x, n, which.y, DiscreteRange(2, 9))\n"
    )
    draws = load(text).draws
    assert [tuple(draw[:4]) for draw in draws] == [
        ("ego.x", "range", 1, 2),
        ("spot.x", "point.x", -5, 5),
        ("spot.y", "point.y", -5, 5),
        ("n", "normal", -math.inf, math.inf),
        ("which", "choice", 0, 1),
        ("a[3]", "integers", 2, 9),
    ]
    assert [draw.place.line for draw in draws] == [1, 2, 2, 3, 4, 5]


def test_describe_gives_values_in_the_programs_units():
    text = "spot = Point in CircularRegion(3 @ 4, 5)\nwho = Uniform(ego, spot)\nrole = Uniform('GK', 'CB')\n"
    program = things(text + "param all = (spot.x, who.y, role)")
    shown = program.describe(np.array([-1.0, 0, 0.5, -0.5]))
    assert shown == {"spot.x": pytest.approx(3), "spot.y": pytest.approx(4), "who": "spot", "role": "GK"}


REGIONS = [
    ("RectangularRegion(3 @ 4, 0, 2, 6)", lambda x, y: (np.abs(x - 3) <= 1) & (np.abs(y - 4) <= 3), 12),
    ("RectangularRegion(0 @ 0, 45 deg, 2, 6)", lambda x, y: (np.abs(x + y) <= 2**0.5) & (np.abs(y - x) <= 18**0.5), 12),
    ("CircularRegion(3 @ 4, 5)", lambda x, y: np.hypot(x - 3, y - 4) <= 5, 25 * math.pi),
    (
        "SectorRegion(3 @ 4, 5, 90 deg, 60 deg)",
        lambda x, y: (np.hypot(x - 3, y - 4) <= 5) & (np.abs(np.arctan2(y - 4, 3 - x)) <= math.pi / 6),
        25 * math.pi / 6,
    ),
    ("PolygonalRegion([0 @ 0, 4 @ 0, 4 @ 4, 2 @ 1, 0 @ 4])", lambda x, y: (y <= 4 - 1.5 * x) | (y <= 1.5 * x - 2), 10),
    (
        "RectangularRegion(0 @ 0, 0, 4, 4).intersect(RectangularRegion(1 @ 1, 0, 4, 4))",
        lambda x, y: (x >= -1) & (y >= -1) & (x <= 2) & (y <= 2),
        9,
    ),
    (
        "RectangularRegion(0 @ 0, 0, 4, 4).difference(RectangularRegion(0 @ 0, 0, 2, 2))",
        lambda x, y: (np.abs(x) >= 1) | (np.abs(y) >= 1),
        12,
    ),
    (
        "RectangularRegion(0 @ 0, 0, 4, 4).union(RectangularRegion(1 @ 1, 0, 4, 4))",
        lambda x, y: (np.maximum(abs(x), abs(y)) <= 2) | (np.maximum(abs(x - 1), abs(y - 1)) <= 2),
        23,
    ),
]


@pytest.mark.parametrize(("text", "inside", "area"), REGIONS)
def test_points_of_a_region_are_uniform(text, inside, area):
    """As many points as its share of the area lie in any half, quarter and eighth of the bounding box."""
    program = things(f"spot = Point in {text}\nparam spot = spot\nrequire spot in {text}")
    scenes = program.instantiate(RNG(0).uniform(-1, 1, (N, 2)))
    points = scenes.params["spot"]
    assert scenes.ok.mean() > 0.9999
    assert inside(*(points.T * (1 - 1e-9))).mean() > 0.999
    low, high = points.min(axis=0), points.max(axis=0)
    grid = RNG(1).uniform(low, high, (200_000, 2))
    within = grid[inside(*grid.T)]
    np.testing.assert_allclose(len(within) / len(grid) * np.prod(high - low), area, rtol=0.02)
    for cut in (0.25, 0.5, 0.7):
        for axis in (0, 1):
            edge = low[axis] + cut * (high - low)[axis]
            share = np.mean(within[:, axis] < edge)
            assert abs(np.mean(points[:, axis] < edge) - share) < 5 * math.sqrt(share * (1 - share) / N) + 0.005


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(some.floats(-100, 100), some.floats(0.001, 100))
def test_both_ends_of_a_range_belong_to_it_and_nothing_beyond(low, width):
    high = low + width
    program = load(
        f"x = Range({low!r}, {high!r})\nego = new Object at 0 @ 0\nparam x = x\nrequire {low!r} <= x <= {high!r}\n"
    )
    scenes = program.instantiate(np.array([[-1.0], [np.nextafter(-1, 0)], [0], [np.nextafter(1, 0)], [1.0]]))
    assert scenes.ok.all()
    assert scenes.params["x"][0] == low
    np.testing.assert_allclose(scenes.params["x"][-1], high, rtol=1e-15)


TWO_STARS = {1: 8 / 60, 2: 8 / 60, 3: 45 / 240, 4: 10 / 48, 5: 27 / 240, 6: 27 / 240, 7: 27 / 240}
STARS = [
    ("xs = Uniform([1, 2], [3, 4, 5])", "*xs, 9", {1: 1 / 6, 2: 1 / 6, 3: 1 / 8, 4: 1 / 8, 5: 1 / 8, 9: 7 / 24}),
    ("xs = Uniform([1, 2], [3])\nys = Uniform((4,), (5, 6, 7))", "*xs, *ys", TWO_STARS),
    ("xs = filter(lambda x: x < 2, [Range(0, 4), Range(0, 4)])", "*xs, 9", {9: 1 / 4 + 1 / 4 + 1 / 12}),
    ("xs = Uniform([1], [])", "*xs, 2", {1: 1 / 4, 2: 3 / 4}),
    ("xs = Uniform([1, 2], [])", "*xs", {1: 1 / 2, 2: 1 / 2}),
    ("xs = Uniform([[1], [2, 3]], [[4, 5]])", "*Uniform(*xs)", {1: 1 / 4, 2: 1 / 8, 3: 1 / 8, 4: 1 / 4, 5: 1 / 4}),
    ("xs = Discrete({(1, 2): 1, (3,): 3})", "*xs, 'z'", {"1": 1 / 12, "2": 1 / 12, "3": 3 / 8, "z": 11 / 24}),
    ("xs = Uniform(range(3), (7,))", "0, *xs", {0: 1 / 2, 1: 1 / 8, 2: 1 / 8, 7: 1 / 4}),
]


@pytest.mark.parametrize(("lines", "stars", "shares"), STARS)
def test_a_star_of_a_random_list_counts_the_elements_that_there_are(lines, stars, shares):
    fixed = things(f"{lines}\nparam value = xs")
    program = things(f"{lines}\nparam value = Uniform({stars})")
    assert program.dim - fixed.dim == 1 + lines.count("ys =") + stars.count("Uniform")
    scenes = program.instantiate(RNG(0).uniform(-1, 1, (N, program.dim)))
    drawn = scenes.params["value"][scenes.ok]
    for value, share in shares.items():
        found = np.mean(np.array([each == value or str(each) == value for each in drawn]))
        assert abs(found - share) < 5 * math.sqrt(share * (1 - share) / len(drawn)), value


CALLS_WITH_STARS = [
    ("max(*pair)", {2: 0.5, 4: 0.5}),
    ("f(*pair)", {12: 0.5, 34: 0.5}),
    ("f(5, *pair[1:])", {52: 0.5, 54: 0.5}),
    ("len(zip(*several))", {1: 0.5, 2: 0.5}),
    ("Vector(*pair).x", {1: 0.5, 3: 0.5}),
]


@pytest.mark.parametrize(("text", "shares"), CALLS_WITH_STARS)
def test_a_star_of_a_random_list_in_any_call(text, shares):
    lines = "def f(a, b):\n    return 10 * a + b\npair = Uniform((1, 2), (3, 4))\n"
    lines += "several = Uniform([[1], [2]], [[1, 2], [3, 4]])\n"
    program = things(f"{lines}param value = {text}")
    drawn = program.instantiate(RNG(0).uniform(-1, 1, (N, program.dim))).params["value"]
    for value, share in shares.items():
        assert abs(np.mean(drawn == value) - share) < 0.02


REFUSED = [
    ("[*xs, 3]", "cannot iterate through a random value"),
    ("DiscreteRange(1, k, weights=[1, 2])", "the ends of a DiscreteRange with weights must be fixed numbers"),
    ("Discrete({1: k, 2: 1})", "the weight of 1 in Discrete must be a fixed number"),
    ("Discrete(xs)", "Discrete takes a dictionary of weights, not a random choice (write Uniform(*items)"),
    ("Uniform(*Uniform([], []))", "a choice among no values"),
]


@pytest.mark.parametrize(("text", "said"), REFUSED)
def test_what_no_column_stands_for_is_refused_with_a_reason(text, said):
    with pytest.raises(ScenicError) as caught:
        things(f"xs = Uniform([1], [2, 3])\nk = DiscreteRange(1, 2)\nparam value = {text}")
    assert said in str(caught.value)


NAMED = [
    "Range(0, 1)",
    "Range(1, k)",
    "Normal(3, 2)",
    "Normal(k, 2)",
    "Normal(0, 1)",
    "TruncatedNormal(5, 2, 1, 8)",
    "TruncatedNormal(k, 2, 1, 8)",
    "TruncatedNormal(0, 1, -1, 1)",
    "DiscreteRange(1, 4)",
    "DiscreteRange(k, 9)",
    "DiscreteRange(1, 3, weights=[1, 2, 1])",
    "Uniform(1, 2, 5)",
    "Uniform('a', 'b')",
    "Uniform(True, False)",
    "Uniform(1, k)",
    "Uniform([1], [2, 3])",
    "Uniform(1 @ 2, 3 @ 4)",
    "Uniform(*some, 9)",
    "Options([1, 2])",
    "Discrete({1: 2, 3: 4})",
    "VerifaiRange(0, 2)",
    "VerifaiDiscreteRange(0, 2)",
    "resample(bell)",
]


@pytest.mark.parametrize("text", NAMED)
def test_a_column_has_the_name_of_its_variable_or_parameter(text):
    before = "k = DiscreteRange(1, 2)\nsome = Uniform([1], [2, 3])\nbell = TruncatedNormal(5, 2, 1, 8)\n"
    kept = "param others = [k, some, bell]\n"
    known = {"k", "some", "bell"}
    for line in (f"mine = {text}\nparam value = mine", f"param mine = {text}", f"param value = [{text}]"):
        names = {draw.name for draw in things(before + kept + line).draws} - known
        assert names == ({"value[0]"} if line.partition("= ")[2][0] == "[" and "value = [" in line else {"mine"})


def test_a_column_of_a_point_has_the_name_of_its_variable_and_an_axis():
    text = "a = new Point in CircularRegion(0 @ 0, 3)\nb = new OrientedPoint on PolylineRegion([0 @ 0, 1 @ 1])\n"
    text += "c = Region.uniformPointIn(CircularRegion(0 @ 0, 3))\nd = Range(0, 1) @ TruncatedNormal(3, 1, 0, 5)\n"
    program = things(text + "param all = [a.x, b.x, c.x, d.x, d.y, a.y, c.y]")
    assert [draw.name for draw in program.draws] == ["a.x", "a.y", "b.along", "c.x", "c.y", "d.x", "d.y"]
