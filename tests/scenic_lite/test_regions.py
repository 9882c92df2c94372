"""Regions: uniform points, the way back from them, membership, algebra; expected numbers are from real Scenic."""

import math
import subprocess
import sys

import numpy as np
import pytest
import shapely

from scenic_lite import ScenicError, load
from tests.scenic_lite.scene import BARE, described, one_scene, param, things

POINTS = 20_000
CHECK = "PolygonalRegion([0 @ 0, 10 @ 0, 10 @ 10, 5 @ 3, 0 @ 10])"
RING = "RectangularRegion(0 @ 0, 0.3, 12, 8).difference(CircularRegion(1 @ 0, 3))"
PARTS = "PolygonalRegion([0@0, 2@0, 2@2, 0@2]).union(PolygonalRegion([4@1, 10@1, 10@9, 8@9]))"
AREAS = [
    "RectangularRegion(3 @ 4, 0, 2, 6)",
    "RectangularRegion(3 @ 4, 0.7, 2, 6)",
    "CircularRegion(3 @ 4, 5)",
    "SectorRegion(3 @ 4, 5, 1, 1.2)",
    "SectorRegion(3 @ 4, 5, 1, 4.5)",
    CHECK,
    RING,
    PARTS,
    "PolygonalRegion([0@0, 6@0, 6@6, 0@6]).union(RectangularRegion(6@6, 0.4, 8, 8))",
    "CircularRegion(0@0, 5).intersect(RectangularRegion(5@0, 0, 10, 10))",
]
POINT_SET = "PointSetRegion('p', [(1, 2), (3, 4), (5, 9)])"  # many θ lead to each of its points
FIXED = [*AREAS, "PolylineRegion([0@0, 10@0, 10@10])", POINT_SET]


def region(text, dialect=3):
    """Return the region that an expression makes."""
    return things(f"spot = new Thing in {text}", dialect).mode.state.points[0].region


def drawn(text, n=POINTS, seed=3):
    program = things(f"spot = new Thing in {text}", 3)
    theta, scenes = program.sample(n, np.random.default_rng(seed))
    return theta, scenes.positions[:, 1]


def chi_square(points, shape, cells=6):
    """Return chi² of the counts in a grid over a shape's bounds; about 1 per degree of freedom if uniform."""
    low_x, low_y, high_x, high_y = shape.bounds
    xs, ys = np.linspace(low_x, high_x, cells + 1), np.linspace(low_y, high_y, cells + 1)
    counts = np.histogram2d(points[:, 0], points[:, 1], (xs, ys))[0]
    boxes = [[shapely.box(xs[i], ys[j], xs[i + 1], ys[j + 1]) for j in range(cells)] for i in range(cells)]
    expected = shapely.area(shapely.intersection(np.array(boxes, dtype=object), shape)) / shape.area * len(points)
    kept = expected > 10
    return float(((counts - expected)[kept] ** 2 / expected[kept]).sum()), int(kept.sum())


@pytest.mark.parametrize("text", AREAS)
def test_points_are_uniform(text):
    """A shift of 0.15 standard deviations makes the statistic three times as large or more."""
    _, points = drawn(text)
    shape = region(text).shape()
    value, cells = chi_square(points, shape)
    assert value < cells + 5 * math.sqrt(2 * cells)
    shifted, _ = chi_square(points + 0.15 * points.std(axis=0), shape)
    assert shifted > cells + 5 * math.sqrt(2 * cells)


@pytest.mark.parametrize("text", AREAS)
def test_the_map_from_the_square_preserves_area(text):
    """What fills the unit square far more evenly than chance does (Roberts' R2 sequence) fills the region so."""
    steps = np.arange(60_000)
    u, v = (steps * 0.7548776662466927) % 1, (steps * 0.5698402909980532) % 1
    there = region(text)
    program = things(f"spot = new Thing in {text}", 3)
    points = program.instantiate(np.stack([2 * u - 1, 2 * v - 1], axis=1)).positions[:, 1]
    value, cells = chi_square(points, there.shape())
    assert value < 0.25 * cells


@pytest.mark.slow
@pytest.mark.parametrize("text", FIXED)
def test_the_way_back_from_points(text):
    program = things(f"spot = new Thing in {text}", 3)
    theta = np.random.default_rng(5).uniform(-1, 1, (500, program.dim))
    scenes = program.instantiate(theta)
    back = program.theta(described(scenes), default=np.zeros(program.dim))
    np.testing.assert_allclose(program.instantiate(back).positions, scenes.positions, atol=1e-5)
    if text != POINT_SET:
        np.testing.assert_allclose(back, theta, atol=1e-6)
    with pytest.raises(ScenicError, match="found no θ that gives spot the position"):
        program.theta({"spot": (500, 0)})


def test_both_numbers_grow_with_the_point():
    """θ of a polygon is a sensible space: x grows with the first number, y with the second."""
    program = things(f"spot = new Thing in {CHECK}", 3)
    theta = np.stack([np.linspace(-1, 1, 200), np.zeros(200)], axis=1)
    assert (np.diff(program.instantiate(theta).positions[:, 1, 0]) > 0).all()
    assert (np.diff(program.instantiate(theta[:, ::-1]).positions[:, 1, 1]) > 0).all()


@pytest.mark.parametrize("text", [CHECK, RING, PARTS, "SectorRegion(3 @ 4, 8, 1, 4.5)"])
def test_rectangles_inside(text):
    """As shapely decides, but for rectangles that all but touch."""
    shape = region(text).shape()
    rng = np.random.default_rng(2)
    low_x, low_y, high_x, high_y = shape.bounds
    x, y, turn = rng.uniform(low_x, high_x, 400), rng.uniform(low_y, high_y, 400), rng.uniform(-3, 3, 400)
    program = load(
        f"{BARE}ego = new Thing at Range({low_x}, {high_x}) @ Range({low_y}, {high_y}), facing Range(-3, 3),\n"
        f"    with width 1.5, with length 2.5\nrequire ego in {text}",
        dialect=3,
    )
    theta = np.stack([2 * (x - low_x) / (high_x - low_x) - 1, 2 * (y - low_y) / (high_y - low_y) - 1, turn / 3], axis=1)
    box = shapely.box(-0.75, -1.25, 0.75, 1.25)
    boxes = [
        shapely.affinity.translate(shapely.affinity.rotate(box, t, (0, 0), use_radians=True), a, b)
        for a, b, t in zip(x, y, turn, strict=True)
    ]
    clear = shapely.covers(shape.buffer(-0.02), boxes) | ~shapely.covers(shape.buffer(0.02), boxes)
    assert clear.sum() > 300 and shapely.covers(shape, boxes).sum() > 5
    np.testing.assert_array_equal(program.valid(theta)[clear], shapely.covers(shape, boxes)[clear])


def test_touching_is_inside():
    for text in (CHECK, "PolygonalRegion([0@0, 10@0, 10@10, 0@10])"):
        assert load(f"ego = new Object at 9.5 @ 0.5, with regionContainedIn {text}", dialect=3).dim == 0
    with pytest.raises(ScenicError, match="leaves its region"):
        load(f"ego = new Object at 9.51 @ 0.5, with regionContainedIn {CHECK}", dialect=3)


def test_an_object_does_not_span_a_hole():
    """All four corners lie in the ring, the middle does not."""
    ring = "RectangularRegion(0@0, 0, 12, 12).difference(RectangularRegion(0@0, 0, 0.5, 0.5))"
    assert param(
        f"{ring}.containsObject(new Object at 0@0, with width 3, with length 3, with requireVisible False)"
    ) in (
        False,
        np.False_,
    )


VALUES = [
    (f"{CHECK}.containsPoint(5 @ 3)", True),
    (f"{CHECK}.containsPoint(5 @ 3.1)", False),
    (f"{CHECK}.distanceTo(5 @ 5)", 2 / math.hypot(5, 7) * 5),
    (f"distance to {CHECK}", 0.0),
    ("RectangularRegion(0 @ 10, 0.3, 2, 4).distanceTo(0 @ 10)", 0.0),
    ("RectangularRegion(0 @ 0, 0, 2, 4).distanceTo(4 @ 6)", 5.0),
    ("CircularRegion(10 @ 0, 2).distanceTo(5 @ 0)", 3.0),
    ("CircularRegion(0@0, 5).intersects(CircularRegion(10@0, 5.01))", True),
    ("CircularRegion(0@0, 5).intersects(CircularRegion(10.2@0, 5))", False),
    ("RectangularRegion(0@0, 0, 4, 4).intersects(PolylineRegion([-9@0, 9@0]))", True),
    ("RectangularRegion(0@0, 0, 20, 20).containsRegion(PolygonalRegion([0@0, 10@0, 1@1]))", True),
    ("RectangularRegion(0@0, 0, 20, 20).containsRegion(PolygonalRegion([0@0, 11@0, 1@1]))", False),
    ("RectangularRegion(0@0, 0, 20, 20).containsRegion(PolygonalRegion([0@0, 11@0, 1@1]), tolerance=2)", True),
    ("PolygonalRegion([0@0, 4@0, 4@4]).area", 8.0),
    ("PolygonalRegion([0@0, 4@0, 4@4]).boundary.length", 8 + math.sqrt(32)),
    ("PolygonalRegion([0@0, 4@0, 4@5]).AABB[1][1]", 5.0),
    ("PolylineRegion([0@0, 10@0, 10@10]).signedDistanceTo(5 @ -2)", -2.0),
    ("PolylineRegion([0@0, 10@0, 10@10]).pointAlongBy(12).y", 2.0),
    ("PolylineRegion([0@0, 10@0, 10@10]).project(12 @ 3).x", 10.0),
    ("PolylineRegion([0@0, 10@0, 10@10]).end.heading", 0.0),
    ("len(PolylineRegion([0@0, 10@0, 10@10]).equallySpacedPoints(5))", 5),
    ("(PolylineRegion([0@0, 10@0]) + PolylineRegion([20@0, 20@30])).length", 40.0),
    ("PolygonalRegion.unionAll([RectangularRegion(0@0, 0, 2, 2), RectangularRegion(1@0, 0, 2, 2)]).area", 6.0),
    ("GridRegion('g', [[0, 1], [0, 0]], 2, 3, 10, 20).containsPoint(12 @ 20)", False),
    ("GridRegion('g', [[0, 1], [0, 0]], 2, 3, 10, 20).containsPoint(10.4 @ 20.4)", True),
    ("everywhere.intersect(CircularRegion(1 @ 2, 3)).radius", 3),
]


@pytest.mark.parametrize(("text", "value"), VALUES)
def test_what_regions_say(text, value):
    assert param(text, 3) == pytest.approx(value, abs=1e-9)


@pytest.mark.long
def test_sizes_of_random_regions_are_not_preferred():
    """Each radius is as likely as any other, and the point is uniform in what it leaves: from real Scenic 3."""
    text = (
        "x = Range(1, 5)\nspot = new Thing in CircularRegion(0@0, x).intersect(RectangularRegion(5@0, 0, 10, 10))\n"
        "param x = x"
    )
    _, scenes = things(text, 3).sample(3000, np.random.default_rng(1))
    assert scenes.params["x"].mean() == pytest.approx(3.0, abs=0.08)
    share = scenes.positions[:, 1] / scenes.params["x"][:, None]
    assert share[:, 0].mean() == pytest.approx(4 / (3 * math.pi), abs=0.015)
    assert share[:, 1].mean() == pytest.approx(0.0, abs=0.04)
    _, scenes = things(text, 2).sample(3000, np.random.default_rng(1))
    assert scenes.params["x"].mean() == pytest.approx(3.78, abs=0.08)  # of real Scenic 2, which rejects


@pytest.mark.long
def test_random_corners():
    program = things("x = Range(5, 10)\nspot = new Thing in PolygonalRegion([0@0, x@0, 10@10])\nparam x = x", 3)
    _, scenes = program.sample(4000, np.random.default_rng(1))
    mean = (scenes.params["x"] + 10) / 3
    assert (scenes.positions[:, 1, 0] - mean).mean() == pytest.approx(0.0, abs=0.1)
    assert scenes.positions[:, 1, 1].mean() == pytest.approx(10 / 3, abs=0.15)


def test_an_empty_intersection_draws_nothing():
    with pytest.raises(ScenicError, match="cannot be drawn from nowhere"):
        things("spot = new Thing in CircularRegion(0@0, 1).intersect(CircularRegion(9@0, 1))", 3)


REFUSED = [
    ("PolygonalRegion([0@0, 1@1, 1@0, 0@1])", "crosses itself"),
    ("PolygonalRegion([0@0, 1@1])", "needs 3 points or more"),
    ("PolygonalRegion([0@0, 1@1, 2@2])", "do not lie on a line"),
    ("PolygonalRegion(polygon=3)", "does not take 1 argument"),
    ("PolylineRegion([0@0])", "needs 2 points or more"),
    ("PolylineRegion([0@0, 0@0])", "two different points"),
    ("CircularRegion(0@0)", "does not take 1 argument"),
    ("GridRegion('g', [[0, 1], [0]], 1, 1, 0, 0)", "all of one length"),
    ("PolylineRegion([0@0, 1@0]).pointsSeparatedBy(0)", "must be positive"),
    ("PolylineRegion([0@0, 1@0]).pointsSeparatedBy(1e-9)", "budget exceeded"),
    ("CircularRegion(0@0, 1).area.foo", "has no attribute 'foo'"),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_refused(text, message):
    with pytest.raises(ScenicError) as caught:
        one_scene(f"param value = {text}", 3)
    assert message in caught.value.message and caught.value.place is not None


@pytest.mark.slow
def test_shapely_is_loaded_by_polygons_alone():
    code = (
        "import sys\nfrom scenic_lite import load\n"
        "load('ego = new Object in CircularRegion(0@0, 3)', dialect=3)\n"
        "assert 'shapely' not in sys.modules\n"
        "load('ego = new Object in PolygonalRegion([0@0, 1@0, 1@1])', dialect=3)\nassert 'shapely' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.slow
def test_a_point_of_an_empty_region_is_in_no_shape():
    text = """
workspace = Workspace(RectangularRegion(0@0, 0, 20, 20).difference(CircularRegion(0@0, 4)))
ego = new Object in workspace, with requireVisible False
c = new Object in not visible RectangularRegion(0@5, 0, 20, 8), with requireVisible False
"""
    with pytest.raises(ScenicError, match="no valid scene"):
        load(text, dialect=3).sample(1, np.random.default_rng(0))
