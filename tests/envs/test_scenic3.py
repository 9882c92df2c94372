"""Programs that Scenic 3 itself loads: columns that are distributed as its own samples, and what the seed decides.

Without Scenic (`pip install 'regista[scenic3]'`) one test is left: that this is said.
Read next: `test_scenic3_episodes`.
"""

import subprocess
import sys
from functools import partial

import numpy as np
import pytest

from tests.envs.scenic3_probes import DRIVE, ROOT, THING, load_program, needed, scenic3

MANY = (
    THING
    + """
low = Range(1, 3)
field = PolygonalRegion([(0, 0), (8, 0), (8, 6), (5, 1), (3, 6), (0, 6)])
square = RectangularRegion(20 @ 0, 30 deg, 4, 8)
disc = CircularRegion(40 @ 0, 5)
sector = SectorRegion(60 @ 0, 5, 40 deg, 100 deg)
line = PolylineRegion([(0, 20), (10, 20), (10, 24)])
box = BoxRegion(position=(90, 0, 0), dimensions=(2, 4, 6))
def doubled(x):
    return 2 * x

ego = new Thing at Range(low, 2 * low) @ -20
new Thing in field, facing Range(-10, 10) deg
new Thing on square
new Thing in disc
new Thing in sector
new Thing on line
new Thing in box
new Thing in field.difference(CircularRegion(1 @ 1, 2))
new Thing in CircularRegion(Range(0, 5) @ 100, low)
new Thing in Uniform(square, disc)
new Thing at (Normal(0, 1), TruncatedNormal(1, 2, 0, 2))
new Thing at (Uniform(1, 5, low), Discrete({1: 3, 2: 1}))
new Thing at (DiscreteRange(0, 4), doubled(low) + max(1, low))
new Thing ahead of ego by Range(1, 2), with yaw Uniform(10, 20) deg
require low > 1.5
"""
)


@pytest.fixture
def load(tmp_path):
    """Write a program and load it."""
    return partial(load_program, tmp_path)


@pytest.mark.slow
def test_without_scenic_it_says_what_to_install():
    code = "import sys; sys.modules['scenic'] = None\nimport regista.envs.scenic3"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert (
        "ImportError: programs of the original Scenic need scenic and greenlet: pip install 'regista[scenic3]'"
        in done.stderr
    )


def drawn(scene):
    """Where the objects of a scene are and where they look."""
    return [[thing.position.x, thing.position.y, thing.position.z, thing.yaw] for thing in scene.objects]


@needed
@pytest.mark.slow
def test_uniform_theta_are_distributed_as_the_scenes_of_scenic(load):
    from scipy.stats import ks_2samp

    program, rng = load(MANY, mode_2d=False), np.random.default_rng(0)
    theta, _ = program.sample(500, rng)
    ours = np.array([drawn(program.scene(row, 0)) for row in theta])  # [samples, objects, numbers]
    with scenic3.program.seeded(1):
        theirs = np.array([drawn(program.scenario.generate()[0]) for _ in range(500)])
    for thing in range(ours.shape[1]):
        for number in range(ours.shape[2]):
            a, b = ours[:, thing, number], theirs[:, thing, number]
            if np.ptp(np.concatenate([a, b])) > 1e-6:
                assert ks_2samp(a, b).pvalue > 0.002, (program.objects[thing], number)
    across = ours[:, 1, 0] + ours[:, 1, 1], theirs[:, 1, 0] + theirs[:, 1, 1]  # x and y together
    assert ks_2samp(*across).pvalue > 0.002


@needed
def test_columns_have_names_lines_and_kinds(load):
    program = load("# first\n\n" + MANY)
    table = {draw.name: (getattr(draw.kind, "num_bins", draw.kind), draw.low, draw.high) for draw in program.draws}
    assert table["low"] == ("range", 1, 3)
    assert table["Thing1.position.x"] == ("point.x", 0, 8)
    assert table["Thing5.position.along"][0] == "point.along"
    assert table["Thing6.position.z"] == ("point.z", -3, 3)
    assert [table[f"Thing11.position{more}"][0] for more in ("", "[2]")] == [3, "integers"]
    assert table["Thing12.position"] == (5, 0, 4)
    assert program.draws[0].place.line == 3 + MANY.splitlines().index("low = Range(1, 3)")
    assert [name for name in program.by_seed if "color" not in name] == []
    assert set(program.describe(np.zeros(program.dim))) == set(table)
    assert program.dim == len(table)


@needed
def test_excluded_columns_are_drawn_from_the_seed(load):
    program = load(DRIVE, nuisance=("speed", "*color*"))
    assert [draw.name for draw in program.draws] == ["other.position"]
    speeds = {program.scene(np.zeros(1), seed).objects[1].velocity.y for seed in (1, 1, 2)}
    assert len(speeds) == 2
    assert load(DRIVE, nuisance=()).dim == 4


@needed
@pytest.mark.slow
def test_points_move_continuously_with_theta(load):
    program = load(MANY)
    columns = [
        index for index, draw in enumerate(program.draws) if draw.name.startswith(("Thing3.", "Thing4.", "Thing5."))
    ]
    path = np.zeros((400, program.dim))
    path[:, columns] = np.linspace(-0.999, 0.999, 400)[:, None]
    places = program.instantiate(path).positions[:, [3, 4, 5]]
    assert np.linalg.norm(np.diff(places, axis=0), axis=-1).max() < 0.2


@needed
@pytest.mark.slow
def test_theta_that_break_a_requirement_are_refused(load):
    program = load(MANY)
    column = [draw.name for draw in program.draws].index("low")
    theta = np.zeros((2, program.dim))
    theta[0, column] = -0.9
    assert program.valid(theta).tolist() == [False, True]
    with pytest.raises(ValueError, match=r"is not a valid scene of .*requirement on line"):
        program.scene(theta[0], 0)
    report = program.report(200, np.random.default_rng(0))
    assert 0.6 < report.valid / report.tried < 0.85
    assert "requirement on line" in str(report)


@needed
def test_values_by_name_are_theta(load):
    program = load(DRIVE)
    theta = program.theta_of({"speed": 2.0, "other.position": 10.0})
    np.testing.assert_allclose(theta, [-0.5, 1.0])
    with pytest.raises(ValueError, match=r"a level needs speed, other.position, got speed$"):
        program.theta_of({"speed": 2.0})
