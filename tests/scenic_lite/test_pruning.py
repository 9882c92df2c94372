"""Pruning: fewer draws are rejected, and the valid scenes are distributed as if they had been."""

import subprocess
import sys

import numpy as np
import pytest

from scenic_lite import Program, ScenicError, load, loader
from tests.scenic_lite.scene import described

SCENES = 4000
CLOSE = 2.2 * np.sqrt(2 / SCENES)  # of two samples' distribution functions
FIELD = "field = RectangularRegion(0 @ 0, 0, 20, 10)\nworkspace = Workspace(field)\n"
DISC = "disc = CircularRegion(0 @ 0, 6)\nworkspace = Workspace(disc)\n"
STREET = "street = PolygonalRegion([0@0, 60@0, 60@12, 12@12, 12@60, 0@60])\n"
TURNED = "facing Range(0, 360) deg"

# Program, the least and the greatest share of valid draws.
PRUNED = {
    "upright": (FIELD + "ego = new Object in field, with width 4, with length 2", 0.85, 0.92),
    "any heading": (FIELD + f"ego = new Object in field, with width 4, with length 2, {TURNED}", 0.6, 0.75),
    "turned": (
        "yard = RectangularRegion(1@2, 45 deg, 9, 9)\nego = new Object contained in yard, with width 4",
        0.4,
        0.6,
    ),
    "half a turn": (
        "yard = RectangularRegion(1@2, 45 deg, 9, 9)\n"
        "ego = new Object in RectangularRegion(3@3, 225 deg, 12, 5), with regionContainedIn yard",
        0.85,
        1,
    ),
    "rectangle in disc": (
        DISC + "spot = new Point in RectangularRegion(0@0, 0, 20, 4)\n"
        f"ego = new Object at spot, with width 2, {TURNED}\nparam twice = spot.position.x * 2\nrequire ego.x > -4",
        0.75,
        0.95,
    ),
    "disc": (DISC + f"ego = new Object in disc, with width 2, {TURNED}", 0.8, 0.9),
    "disc in disc": (f"{DISC}ego = new Object in CircularRegion(4@0, 5), {TURNED}", 0.85, 1),
    "wide sector": (
        "workspace = Workspace(SectorRegion(0@0, 9, 30 deg, 300 deg))\nego = new Object in CircularRegion(0@0, 10)",
        0.9,
        1,
    ),
    "polygon": (
        STREET + f"ego = new Object in street, with length 4, with regionContainedIn street, {TURNED}",
        0.7,
        0.9,
    ),
    "steps": (
        FIELD + "spot = new OrientedPoint in RectangularRegion(8@0, 0, 10, 8), facing 30 deg\n"
        "ego = new Object ahead of spot by 3\nb = new Object at spot offset by 2@-2, with allowCollisions True",
        0.7,
        1,
    ),
    "shared": (
        FIELD + "spot = new Point in RectangularRegion(5@0, 0, 20, 12)\nego = new Object at spot.position + (0@-2)\n"
        "b = new Object at spot.position + (0@2), with width 3\n"
        "c = new Object at spot, with regionContainedIn CircularRegion(3@0, 5)",
        0.9,
        1,
    ),
    "sizes": (
        FIELD + "ego = new Object in field, with width Range(1, 4), with length Uniform(2, 5, 3)\n"
        f"b = new Object in field, with width DiscreteRange(1, 4), with allowCollisions True, {TURNED}",
        0.5,
        0.8,
    ),
    "choice": (FIELD + "ego = new Object in Uniform(RectangularRegion(0@0,0,24,2), CircularRegion(0@0,2))", 0.8, 0.99),
    "one with noise": (
        FIELD + "ego = new Object in field\nb = new Object in field, with allowCollisions True\nmutate b",
        0.6,
        0.9,
    ),
    "row by row": (
        DISC + "def free(p):\n    if p.x > 1:\n        return p.y > 0\n    return True\n"
        "ego = new Object in RectangularRegion(0@0, 0, 12, 12)\n"
        "b = new Object in CircularRegion(0@0, 6).difference(RectangularRegion(0@0, 0, 3, 3))\n"
        "require free(ego.position)\nrequire free(b.position)",
        0.4,
        0.7,
    ),
    "followed field": (
        DISC + "v = new Object in PolygonalRegion([0@0, 9@0, 5@5]), with width 0.1, with length 0.1\n"
        "f = VectorField('f', lambda p: v.position.x / 3 + p.y / 9)\n"
        "ego = new Object following f from 0@0 for 4, with allowCollisions True",
        0.9,
        1,
    ),
}  # fmt: skip


SLOW = ("row by row",)


def unpruned(text):
    """Return the same program, whose invalid draws are all rejected."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loader, "prune", lambda state: None)
        return load(text, dialect=3)


def numbers(scenes):
    """Return all that varies, and the sums of pairs of it: [N, K]."""
    params = [np.asarray(value, dtype=float)[:, None] for value in scenes.params.values()]
    table = np.concatenate([scenes.positions.reshape(SCENES, -1), scenes.headings, *params], axis=1)
    pairs = [table[:, i] + table[:, j] for i in range(table.shape[1]) for j in range(i)]
    return np.concatenate([table, np.stack(pairs, axis=1)], axis=1)


def gap(a, b):
    """Return the greatest distance of two distribution functions."""
    both = np.concatenate([a, b])
    below = [np.searchsorted(np.sort(each), both, side="right") / len(each) for each in (a, b)]
    return np.abs(below[0] - below[1]).max()


@pytest.mark.slow
@pytest.mark.sample(4)
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in PRUNED]
)
def test_the_same_scenes_as_by_rejection(name):
    text, least, most = PRUNED[name]
    program, plain = load(text, dialect=3), unpruned(text)
    share = program.report(SCENES, np.random.default_rng(0)).accepted / SCENES
    assert least <= share <= most
    assert share >= plain.report(SCENES, np.random.default_rng(0)).accepted / SCENES - 0.01
    assert [draw[:2] for draw in program.draws] == [draw[:2] for draw in plain.draws]
    theta, scenes = program.sample(SCENES, np.random.default_rng(1))
    ours, theirs = (numbers(each) for each in (scenes, plain.sample(SCENES, np.random.default_rng(2))[1]))
    assert max(gap(a, b) for a, b in zip(ours.T, theirs.T, strict=True)) < CLOSE
    back = program.instantiate(program.theta(described(scenes), default=theta))
    np.testing.assert_allclose(back.positions, scenes.positions, atol=1e-9)
    for region, other in zip(program.drawn_regions, plain.drawn_regions, strict=True):
        np.testing.assert_array_equal(np.concatenate(region.outlines()), np.concatenate(other.outlines()))


def test_draws_say_what_is_left():
    program = load(FIELD + "ego = new Object in field, with width 4, with length 2", dialect=3)
    assert [(draw.name, draw.low, draw.high) for draw in program.draws] == [("ego.x", -9, 9), ("ego.y", -4, 4)]
    assert program.describe(np.array([1.0, -1.0])) == {"ego.x": 9, "ego.y": -4}
    with pytest.raises(ScenicError, match="found no θ that gives ego the position"):
        program.theta({"ego": (9.5, 0)})
    disc = load(DISC + "ego = new Object in RectangularRegion(0@0, 0, 20, 20)", dialect=3)
    low, high = disc.draws[0][2:4]
    assert low == pytest.approx(-5.5, abs=0.01) and high == pytest.approx(5.5, abs=0.01)
    shown = disc.describe(disc.theta({"ego": (3, -2)})[0])
    assert shown == {"ego.x": pytest.approx(3), "ego.y": pytest.approx(-2)}


@pytest.mark.parametrize("extra", ["mutate", "require[0.5] ego in CircularRegion(0 @ 0, 1)"])
def test_noise_and_soft_requirements_prune_nothing(extra):
    text = "workspace = Workspace(RectangularRegion(0 @ 0, 0, 6, 4))\nego = new Object in CircularRegion(0 @ 0, 1)\n"
    program = load(text + extra, dialect=3)
    assert (program.draws[0].low, program.draws[0].high) == (-1, 1)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("ego = new Object in RectangularRegion(30 @ 0, 0, 4, 4)", "the workspace"),
        ("ego = new Object in CircularRegion(14 @ 0, 3)", "the workspace"),
        ("ego = new Object in field, with width 21, with length 21", "the workspace"),
        (
            "ego = new Object in field, with width Range(30, 40), with length 31, facing Range(0, 3)",
            "the workspace",
        ),
        ("ego = new Object in field, with regionContainedIn CircularRegion(50 @ 0, 3)", "its region"),
    ],
)
def test_what_fits_nowhere_is_an_error_of_the_program(text, place):
    with pytest.raises(ScenicError, match=rf"3:\d+: ego does not fit into {place}"):
        load(FIELD + text, dialect=3)


@pytest.mark.parametrize("size", ["1e300", "1e13", "0"])
def test_regions_of_any_size_are_no_crash(size):
    for region in (f"CircularRegion(0 @ 0, {size})", f"RectangularRegion(0 @ 0, 0.5, {size}, {size})"):
        try:
            load(DISC + f"ego = new Object in {region}, with regionContainedIn {region}", dialect=3)
        except ScenicError as error:
            assert error.place is not None


@pytest.mark.slow
def test_upright_rectangles_stay_cheap():
    program = load(FIELD + "ego = new Object in field", dialect=3)
    assert not program.tape.steps
    code = f"import sys, scenic_lite; scenic_lite.load({FIELD + 'ego = new Object in field'!r}, dialect=3)"
    subprocess.run([sys.executable, "-c", code + "; assert 'shapely' not in sys.modules"], check=True)


def test_small_batches_draw_what_the_acceptance_calls_for(monkeypatch):
    program = load("ego = new Object at Range(0, 10) @ 0\nrequire ego.x > 5", dialect=3)
    rows = []
    count = Program._evaluate
    monkeypatch.setattr(Program, "_evaluate", lambda self, theta: rows.append(len(theta)) or count(self, theta))
    program.sample(256, np.random.default_rng(0))
    assert sum(rows) < 256 * 5


def test_a_point_out_of_sight_is_drawn_where_its_object_has_room():
    program = load(
        "workspace = Workspace(RectangularRegion(0 @ 0, 0, 10, 10))\n"
        "ego = new Object at 0 @ 0, with visibleDistance 2\n"
        "a = new Object not visible, with width 2, with length 2, with requireVisible False",
        dialect=3,
    )
    assert [draw[:4] for draw in program.draws] == [("a.x", "point.x", -4, 4), ("a.y", "point.y", -4, 4)]
    scenes = program.sample(500, np.random.default_rng(0))[1]
    assert np.hypot(*scenes.positions[:, 1].T).min() > 2
