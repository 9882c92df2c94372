"""Program: batches, rules, sampling, reports."""

import copy
import math
import pickle

import numpy as np
import pytest
from scene import things

from scenic_lite import RejectionReport, ScenicError, load

RNG = np.random.default_rng
EVERYTHING = """
import math
x = Range(-20, 20)
workspace = Workspace(RectangularRegion(0 @ 0, 0, 100, 80))
ego = Object at x @ Normal(0, 3), facing Range(-180, 180) deg, with viewAngle 200 deg
a = Object in CircularRegion(10 @ 0, 12), with width Range(1, 3), with kind Uniform('a', 'b'), facing toward ego
b = Object ahead of a by TruncatedNormal(3, 1, 1, 5), with length DiscreteRange(1, 4), with near Uniform(ego, a)
c = Object in PolygonalRegion([0 @ 0, 30 @ 0, 30 @ 30, 10 @ 10, 0 @ 30]), facing 30 deg relative to b.heading
d = Object on PolylineRegion([-40 @ -30, 0 @ -20, 40 @ -30]), with requireVisible Uniform(True, False)
param far = math.hypot(a.x - b.x, a.y - b.y) ** 1.5 if 1 < 2 else 0
param words = f"{x:.2f} " + str(DiscreteRange(1, 3))
param place = Uniform(1 @ 2, 3 @ 4) + a.position
require (distance from ego to c) > 5 and (angle from ego to c) < 2
require ego can see a
require[0.5] x > 0
"""


@pytest.fixture(scope="module")
def everything():
    return load(EVERYTHING)


def same(a, b):
    """Return equality bit for bit, nan included, of arrays or plain values."""
    if isinstance(a, np.ndarray) and a.dtype.kind == "f":
        return np.array_equal(a.view(np.int64), b.view(np.int64))
    return np.array_equal(a, b)


def test_row_of_a_batch_is_a_batch_of_one(everything):
    theta = RNG(0).uniform(-1, 1, (257, everything.dim))
    whole = everything.instantiate(theta)
    assert 0.01 < whole.ok.mean() < 0.99
    for i in range(0, len(theta), 8):
        one = everything.instantiate(theta[i : i + 1])
        assert same(one.positions, np.ascontiguousarray(whole.positions[i : i + 1]))
        assert same(one.headings, np.ascontiguousarray(whole.headings[i : i + 1]))
        assert same(one.failed, whole.failed[i : i + 1]) and one.ok[0] == whole.ok[i]
        for name, value in one.params.items():
            assert same(value, np.ascontiguousarray(whole.params[name][i : i + 1])), name
        for name, column in one.properties.items():
            for mine, other in zip(column, whole.properties[name], strict=True):
                if isinstance(mine, np.ndarray):
                    assert same(mine, np.ascontiguousarray(other[i : i + 1])), name


def test_halves_of_a_batch_make_the_whole(everything):
    theta = RNG(1).uniform(-1, 1, (1001, everything.dim))
    whole = everything.instantiate(theta).positions
    halves = [everything.instantiate(part).positions for part in (theta[:333], theta[333:])]
    assert same(whole, np.concatenate(halves))


def test_theta_beyond_its_range_is_clipped(everything):
    a = everything.instantiate(np.full((1, everything.dim), 1.0))
    b = everything.instantiate(np.full((1, everything.dim), 7.0))
    np.testing.assert_array_equal(a.positions, b.positions)


def test_rows_that_are_no_numbers_are_not_valid():
    program = things("thing = new Thing at Range(0, 1) @ Range(0, 1)")
    theta = np.zeros((3, 2))
    theta[1, 0] = np.nan
    np.testing.assert_array_equal(program.valid(theta), [True, False, True])


def test_rows_that_divide_by_zero_are_not_valid():
    program = things("x = DiscreteRange(0, 1)\nthing = new Thing at (1 / x) @ 0")
    np.testing.assert_array_equal(program.valid(np.array([[-0.5], [0.5]])), [False, True])


def test_theta_of_a_wrong_shape_is_refused():
    program = things("thing = new Thing at Range(0, 1) @ Range(0, 1)")
    with pytest.raises(
        ValueError, match=r"theta must be an array of numbers of the shape \[N, 2\] for <program>, not \[3\]"
    ):
        program.instantiate(np.zeros(3))


def test_program_without_anything_random():
    program = load("ego = Object at 3 @ 4")
    assert program.dim == 0
    theta, scenes = program.sample(5, RNG(0))
    assert theta.shape == (5, 0)
    np.testing.assert_array_equal(scenes.positions, [[[3, 4]]] * 5)


def test_sampling_gives_only_valid_scenes_and_repeats_itself(everything):
    theta, scenes = everything.sample(300, RNG(5))
    assert scenes.ok.all()
    np.testing.assert_array_equal(theta, everything.sample(300, RNG(5))[0])
    np.testing.assert_array_equal(everything.valid(theta), True)


def test_sampling_is_uniform_over_the_valid_part():
    program = things("x = Range(0, 10)\ny = Range(0, 10)\nthing = new Thing at x @ y\nrequire x + y < 2")
    theta, _ = program.sample(4000, RNG(0))
    x, y = ((theta + 1) * 5).T
    assert (x + y < 2).all()
    assert abs(np.mean(x < 1) - 0.75) < 0.035  # the triangle's share left of its middle


def test_soft_requirement_holds_in_its_share_and_elsewhere_by_chance():
    program = things("x = Range(0, 1)\nparam x = x\nrequire[0.5] x > 0.8")
    assert program.report(100, RNG(0)).acceptance == 1  # it can be left out, so it makes no θ invalid
    _, scenes = program.sample(4000, RNG(0))
    share = np.mean(scenes.params["x"] > 0.8)
    assert abs(share - (0.5 + 0.5 * 0.2)) < 0.04


# ------------------------------------------------------------ rules


@pytest.mark.parametrize(
    ("second", "meets"),
    [
        ("at 1 @ 0", True),  # touching counts
        ("at 1.000001 @ 0", False),
        ("at 0.9 @ 0.9", True),
        ("at 1.1 @ 0.9", False),
        ("at 1.2 @ 0, facing 45 deg", True),
        ("at 1.21 @ 0, facing 45 deg", False),
        ("at 1.2 @ 1.2, facing 45 deg", False),
        ("at 0.8 @ 0.8, facing 45 deg", True),
        ("at 3 @ 0, with width 5", True),
        ("at 3 @ 0, with length 5", False),
        ("at 3 @ 0, with length 5, facing 90 deg", True),
    ],
)
def test_overlap(second, meets):
    rules = "with requireVisible False"
    spread = 1e-12  # random, so that the overlap is a matter of the scene and not of the program
    program = load(f"ego = Object at Range(0, {spread}) @ 0, {rules}\nb = Object {second}, {rules}")
    assert program.requirements[0].label == "b overlaps ego"
    assert program.valid(np.full((1, 1), -1.0))[0] == (not meets)


def test_collisions_are_allowed_if_either_allows_them():
    text = "ego = Object at Range(0, 1) @ 0\nb = Object at 0 @ 0, with allowCollisions True"
    assert load(text).report(10, RNG(0)).acceptance == 1


@pytest.mark.parametrize("upright", [True, False])
def test_overlaps_of_many_agree_with_pairs_one_by_one(upright):
    turn = "" if upright else ", facing Range(0, 360) deg"
    text = "\n".join(
        f"o{i} = Object at Range(0, 9) @ Range(0, 9), with width {1 + i}{turn}, with requireVisible False"
        for i in range(5)
    )
    program = load(text + "\nego = o0")
    scenes = program.instantiate(RNG(0).uniform(-1, 1, (300, program.dim)))
    corners = outlines(scenes)
    for column, rule in enumerate(program.requirements):
        j, i = (int(name[1:]) for name in rule.label.split(" overlaps "))
        expected = [meet(corners[n, i], corners[n, j]) for n in range(300)]
        np.testing.assert_array_equal(scenes.failed[:, column], expected)


def outlines(scenes):
    half = np.array([[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]])
    size = np.stack([scenes.properties["width"], scenes.properties["length"]], -1)[None, :, None] * half
    c, s = np.cos(scenes.headings)[..., None], np.sin(scenes.headings)[..., None]
    turned = np.stack([size[..., 0] * c - size[..., 1] * s, size[..., 0] * s + size[..., 1] * c], -1)
    return scenes.positions[:, :, None] + turned  # [N, O, 4, 2]


def meet(a, b):
    """Return whether two convex quadrilaterals meet: no edge of either separates them."""
    for one in (a, b):
        for p, q in zip(one, np.roll(one, -1, axis=0), strict=True):
            normal = np.array([q[1] - p[1], p[0] - q[0]])
            if max(a @ normal) < min(b @ normal) or max(b @ normal) < min(a @ normal):
                return False
    return True


@pytest.mark.parametrize(
    ("thing", "inside"),
    [
        ("at 9.5 @ 4.5", True),  # touching the edge from inside
        ("at 9.51 @ 0", False),
        ("at 0 @ -4.51", False),
        ("at 9.3 @ 0, facing 45 deg", False),
        ("at 9.29 @ 0, facing 45 deg", True),
        ("at 8 @ 0, with width 4", True),
        ("at 8 @ 0, with width 4, with length 10", True),
        ("at 8 @ 0, with width 4, with length 10.1", False),
    ],
)
def test_containment_in_the_workspace(thing, inside):
    text = "workspace = Workspace(RectangularRegion(0 @ 0, 0, 20, 10))\n"
    if inside:
        assert load(f"{text}ego = Object {thing}").report(1, RNG(0)).acceptance == 1
    else:
        with pytest.raises(ScenicError, match="ego leaves the workspace in every scene"):
            load(f"{text}ego = Object {thing}")


@pytest.mark.parametrize(
    ("region", "inside", "outside"),
    [
        ("PolygonalRegion([0 @ 0, 9 @ 0, 9 @ 9, 4.5 @ 3, 0 @ 9])", "4.5 @ 2.4", "4.5 @ 2.6"),  # the notch enters it
        ("PolygonalRegion([0 @ 0, 9 @ 0, 9 @ 9, 0 @ 9])", "0.5 @ 0.5", "0.4 @ 0.5"),
        ("SectorRegion(0 @ 0, 9, 0, 300 deg)", "0 @ 2", "0 @ -0.4"),  # the missing wedge enters it
        ("SectorRegion(0 @ 0, 9, 0, 90 deg)", "0 @ 1.01", "0 @ 0.99"),
        ("CircularRegion(0 @ 0, 5)", "4.47 @ 0", "4.48 @ 0"),
        ("RectangularRegion(0 @ 0, 45 deg, 2, 2)", "0 @ 0.41", "0 @ 0.42"),
    ],
)
def test_containers_hold_whole_rectangles(region, inside, outside):
    text = f"box = {region}\nego = Object at {{}}, with regionContainedIn box"
    assert load(text.format(inside)).report(1, RNG(0)).acceptance == 1
    with pytest.raises(ScenicError, match="ego leaves its region in every scene"):
        load(text.format(outside))


def test_own_container_replaces_the_workspace():
    text = (
        "workspace = Workspace(RectangularRegion(0 @ 0, 0, 4, 4))\nyard = CircularRegion(50 @ 0, 2)\n"
        "ego = Object at Range(47, 53) @ 0, with regionContainedIn yard"
    )
    _, scenes = load(text).sample(500, RNG(0))
    reach = math.sqrt(4 - 0.25) - 0.5
    assert np.abs(scenes.positions[:, 0, 0] - 50).max() <= reach + 1e-6
    assert np.abs(scenes.positions[:, 0, 0] - 50).max() > reach - 0.02


def test_objects_must_be_visible_unless_switched_off():
    program = load("ego = Object at 0 @ 0\nb = Object at Range(0, 100) @ 10")
    _, scenes = program.sample(500, RNG(0))
    edge = math.sqrt(50**2 - 9.5**2) + 0.5  # the near corner is 50 away
    assert edge - 0.5 < scenes.positions[:, 1, 0].max() <= edge
    assert program.requirements[-1].label == "b is not visible from ego"


# ------------------------------------------------------------ reports


def test_report_of_an_impossible_program():
    text = (
        "ego = Object at Range(0, 10) @ 0, with requireVisible False\n"
        "keeper = Object at Range(0, 10) @ 0, with requireVisible False\n"
        "\n"
        "require (distance from ego to keeper) > 11\n"
        "require ego.x > keeper.x + 20\n"
    )
    with pytest.raises(ScenicError) as caught:
        load(text).sample(1, RNG(0))
    assert caught.value.kind == "rejection"
    assert str(caught.value) == (
        "<program>: no valid scene in 4096 draws\n"
        "    line 4: require (distance from ego to keeper) > 11      rejected 100%\n"
        "    line 5: require ego.x > keeper.x + 20                   rejected 100%\n"
        "    line 2: keeper overlaps ego                             rejected 19%"
    )


def test_report_of_a_possible_program():
    text = "ego = Object at 0 @ 0\nx = Range(0, 4)\nb = Object at x @ 0\nrequire x < 3 as near"
    report = load(text).report(1000, RNG(0))
    assert 0.45 < report.acceptance < 0.55
    assert str(report).splitlines()[0] == "<program>: 50.2% of 1000 draws are valid"
    assert [rule.label for rule, _ in report.rejected] == ["near", "b overlaps ego"]


def test_a_report_rounds_no_share_to_none_or_all():
    rule = load("ego = Object at Range(0, 1) @ 0\nrequire ego.x > 0.5").requirements[0]
    report = RejectionReport("a.scenic", 4096, 4095, ((rule, 1 / 4096),))
    assert str(report).splitlines()[0] == "a.scenic: >99.9% of 4096 draws are valid"
    assert str(report).endswith("rejected <0.1%")


@pytest.mark.parametrize(
    "text", ["Uniform([Range(0, 2), 2], [3])", "list(filter(lambda v: v > 1, [1, Range(0, 3), 2]))"]
)
def test_a_row_holds_its_own_numbers_in_a_chosen_list(text):
    program = load(f"ego = new Object at 0 @ 0\nparam chosen = {text}\n")
    theta = np.random.default_rng(0).uniform(-1, 1, (8, program.dim))
    chosen = program.instantiate(theta).params["chosen"]
    assert list(chosen) == [program.instantiate(row[None]).params["chosen"][0] for row in theta]


def test_params_of_a_program_are_plain_or_random():
    program = things("param a = 3, b = 'x', c = [1, 2 @ 3], d = Range(0, 1), 'e f' = globalParameters.a + 1")
    assert program.params == {"a": 3, "b": "x", "c": [1, (2, 3)], "e f": 4}
    assert set(program.instantiate(np.zeros((2, 1))).params) == {"a", "b", "c", "d", "e f"}


def test_behaviors_and_monitors_are_kept():
    text = (
        "behavior Walk(speed, to=None):\n    while True:\n        take speed\n"
        "monitor Watch:\n    while True:\n        wait\n"
        "thing = new Thing with behavior Walk(Range(1, 5), ego)\n"
        "terminate when ego.x > 5\n"
    )
    program = things(text)
    assert set(program.behaviors) == {"Walk", "Watch"}
    assert [call.behavior.name for call in program.monitors] == ["Watch"]
    assert len(program.terminations) == 1
    assert [info.behavior for info in program.objects] == [None, "Walk"]
    arguments = program.instantiate(np.array([[0.5], [-1]])).behavior_arguments[1]
    assert arguments["to"] == 0  # the ego, by its index
    np.testing.assert_array_equal(arguments["speed"], [4, 1])
    assert [draw.name for draw in program.draws] == ["thing.behavior.speed"]


@pytest.mark.parametrize(
    ("theta", "found"),
    [
        ([0.0], "not [1]"),
        ([[0.0, 0.0]], "not [1, 2]"),
        ([["a"]], "an array of <U1"),
        (None, "object"),
        ([[1j]], "complex"),
    ],
)
def test_theta_that_is_none_is_refused(theta, found):
    program = load("x = Range(0, 1)\nego = Object at x @ 0")
    with pytest.raises(ValueError) as caught:
        program.instantiate(theta)
    assert str(caught.value).startswith("theta must be an array of numbers of the shape [N, 1] for <program>")
    assert found in str(caught.value)


def test_no_scenes_are_no_scenes():
    program = load("x = Range(0, 1)\nego = Object at x @ 0\nparam text = f'{x}'")
    theta, scenes = program.sample(0, RNG(0))
    assert theta.shape == (0, 1) and scenes.positions.shape == (0, 1, 2) and len(scenes.params["text"]) == 0
    with pytest.raises(ValueError, match="a number of scenes is 0 or more, not -1"):
        program.sample(-1, RNG(0))
    with pytest.raises(ValueError, match="a report needs at least one draw, not 0"):
        program.report(0, RNG(0))


def test_copies_of_a_program_are_the_program_and_pickling_says_what_to_do_instead():
    program = load("ego = new Object at Range(0, 1) @ 2", dialect=3)
    assert copy.copy(program) is program
    assert copy.deepcopy({"it": program})["it"] is program
    with pytest.raises(TypeError, match="pass the text of"):
        pickle.dumps(program)


def test_errors_survive_pickling():
    with pytest.raises(ScenicError) as caught:
        load("ego = new Object at 1 @ oops", dialect=3)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value)
    assert (again.kind, again.place) == (caught.value.kind, caught.value.place)


def test_a_report_says_that_soft_requirements_do_not_count():
    program = load("ego = new Object at Range(-1, 1) @ 2\nrequire[0.5] ego.x > 0", dialect=3)
    report = program.report(64, RNG(0))
    assert report.acceptance == 1
    assert "soft requirement" in str(report)
