"""Programs that Scenic 3 itself loads: columns that are distributed as its own samples, and episodes that repeat.

Without Scenic (`pip install 'regista[scenic3]'`) one test is left: that this is said.
"""

import os
import pickle
import random
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ued.gym_upomdp import LevelError

ROOT = Path(__file__).parent.parent.parent

try:
    import ued.scenic3 as scenic3
except ImportError:
    scenic3 = None
needed = pytest.mark.skipif(scenic3 is None, reason="Scenic 3 is not installed: pip install 'regista[scenic3]'")

THING = """
class Thing:
    requireVisible: False
    allowCollisions: True
    color: (Range(0, 1), 0, 0)
"""
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
DRIVE = (
    """
param render = False
model scenic.simulators.newtonian.model
"""
    + THING
    + """
behavior Wander():
    while True:
        wait
        self.velocity = Vector(Range(-1, 1), self.velocity.y)

speed = Range(1, 5)
ego = new Thing at (0, 0), with behavior Wander
other = new Thing at (0, Range(5, 10)), with velocity (0, speed), with behavior Wander
terminate when other.position.y > 12
"""
)
MODULAR = """
param render = False
param weather = Uniform('sun', 'rain')
model scenic.simulators.newtonian.model
class Thing:
    length: 2
    requireVisible: False
    allowCollisions: True
behavior Go(pace):
    while True:
        wait
        self.velocity = Vector(pace, 0)
scenario Late(pace):
    setup:
        new Thing at (0, 60), with behavior Go(pace)
scenario Main():
    setup:
        gap = Range(4, 5)
        ego = new Thing at (0, 0)
        other = new Thing ahead of ego by gap, with behavior Go(Range(1, 2))
    compose:
        wait
        do Late(Range(3, 4)) for 1 seconds
        do choose Late(1), Late(2)
"""
STILL = DRIVE.replace("terminate when other.position.y > 12", "")


@pytest.fixture
def load(tmp_path):
    """Write a program and load it."""

    def loaded(text, **settings):
        path = tmp_path / f"program{len(list(tmp_path.iterdir()))}.scenic"
        path.write_text(text)
        return scenic3.ScenicProgram(path, **settings)

    return loaded


def test_without_scenic_it_says_what_to_install():
    code = "import sys; sys.modules['scenic'] = None\nimport ued.scenic3"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert "ImportError: programs for Scenic itself need it and greenlet: pip install 'regista[scenic3]'" in done.stderr


def drawn(scene):
    """Where the objects of a scene are and where they look."""
    return [[thing.position.x, thing.position.y, thing.position.z, thing.yaw] for thing in scene.objects]


@needed
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
    table = {draw.name: (getattr(draw.kind, "cells", draw.kind), draw.low, draw.high) for draw in program.draws}
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
def test_theta_that_break_a_requirement_are_refused(load):
    program = load(MANY)
    column = [draw.name for draw in program.draws].index("low")
    theta = np.zeros((2, program.dim))
    theta[0, column] = -0.9
    assert program.valid(theta).tolist() == [False, True]
    with pytest.raises(ValueError, match=r"is no valid scene of .*requirement on line"):
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


# ---------------------------------------------------------------- episodes


if scenic3 is not None:
    from gymnasium.spaces import Box

    class Pusher(scenic3.Role):
        """Sees where both are; sets its own speed."""

        observation_space = Box(-np.inf, np.inf, (3,), np.float32)
        action_space = Box(-9.0, 9.0, (1,), np.float32)
        max_steps = 30
        mistaken = False

        def observe(self, simulation):
            ego, other, *_ = simulation.objects
            return np.array([ego.position.y, other.position.x, other.position.y], np.float32)

        def act(self, action, simulation):
            if self.mistaken:
                raise RuntimeError("my mistake")
            simulation.objects[0].velocity = type(simulation.objects[0].velocity)(0, float(action[0]))
            return ()

        def judge(self, simulation):
            ego, other, *_ = simulation.objects
            return float(ego.position.y), bool(ego.position.y > other.position.y), None


def played(upomdp, steps=20, seed=0):
    """Play with random actions; return all that was seen."""
    rng, seen = np.random.default_rng(seed), []
    for _ in range(steps):
        outcome = upomdp.step(rng.uniform(-1, 2, (upomdp.num_envs, 1)))
        seen.append(np.concatenate([outcome[0].ravel(), *(np.asarray(part, float) for part in outcome[1:4])]))
    return np.array(seen)


@pytest.fixture
def make(load):
    """Make environments of a program; they are closed at the end."""
    made = []

    def environments(text, num_envs=2):
        made.append(scenic3.ScenicUPOMDP(load(text), Pusher(), num_envs))
        return made[-1]

    yield environments
    for each in made:
        each.close()


@needed
def test_a_level_and_its_actions_repeat_an_episode(make):
    upomdp = make(STILL)
    levels = upomdp.sample_levels(2)
    upomdp.reset_to_levels(levels)
    first = played(upomdp)
    upomdp.reset_to_levels(levels)
    np.testing.assert_array_equal(first, played(upomdp))
    other = levels.copy()
    other["seed"] += 1
    upomdp.reset_to_levels(other)
    assert not np.array_equal(first, played(upomdp))


@needed
def test_episodes_end_by_the_program_the_role_and_the_clock(make):
    upomdp = make(DRIVE)
    theta = np.array(
        [upomdp.theta_of({"speed": 4.0, "other.position": 5.0}), upomdp.theta_of({"speed": 1.0, "other.position": 5.0})]
    )
    upomdp.reset(options={"theta": theta})
    endings = []
    for _ in range(31):
        _, _, terminated, truncated, info = upomdp.step(np.array([[0.0], [0.0]]))
        endings += [(int(k), bool(terminated[k]), info["ending"][k]) for k in np.flatnonzero(terminated | truncated)]
    assert endings[0][:2] == (0, True) and "line" in endings[0][2]
    assert endings[1][:2] == (1, False) and "time limit" in endings[1][2]
    upomdp.reset(options={"theta": theta})
    for _ in range(20):
        seen, reward, terminated, _, info = upomdp.step(np.array([[0.0], [9.0 - 0.5]]))
        if terminated.any():
            break
    assert terminated.tolist() == [False, True]
    assert info["final_obs"][1, 0] > info["final_obs"][1, 2] > seen[1, 0] == 0  # begun again
    assert reward[1] == pytest.approx(info["final_obs"][1, 0], rel=1e-6)


@needed
def test_a_requirement_that_is_broken_on_the_way_ends_an_episode(make):
    upomdp = make(STILL + "require always other.position.y < 7.2", 1)
    upomdp.reset(options={"theta": [[1.0, -1.0]]})
    outcomes = [upomdp.step(np.zeros((1, 1))) for _ in range(6)]
    assert [outcome[2].item() for outcome in outcomes] == [False] * 4 + [True, False]
    assert outcomes[4][4]["ending"].tolist() == ["rejected"] and outcomes[4][4]["success"].tolist() == [0]


@needed
def test_scenarios_of_several_parts_are_played(make):
    upomdp = make(MODULAR, 1)
    assert [draw.name for draw in upomdp.draws] == ["param weather", "gap", "other.behavior.pace"]
    upomdp.reset(options={"theta": [[0.0, 0.0, -1.0]]})
    seen = [upomdp.step(np.zeros((1, 1)))[0][0] for _ in range(2)]
    np.testing.assert_allclose(seen, [[0, 0, 6.5], [0, 0.1, 6.5]], atol=1e-6)  # 4.5 m between two of 2 m
    assert len(played(upomdp, 40)) == 40


@needed
def test_without_an_ego_it_says_who_might_act(make):
    upomdp = make("param render = False\nmodel scenic.simulators.newtonian.model\nnew Object at (Range(0, 1), 0)", 1)
    with pytest.raises(LevelError, match=r"the program has no ego; name the object that acts by `Role.agent`"):
        upomdp.reset(seed=0)


@needed
def test_it_is_seen_from_above(make):
    upomdp = make(STILL)
    upomdp.reset(seed=0, options={"theta": [[0, -1], [0, 1]]})
    near, far = upomdp.render()
    assert near.dtype == np.uint8 and near.shape == far.shape == (160, 320, 3)
    heights = [np.argwhere((frame == scenic3.view.OTHER).all(-1))[:, 0].mean() for frame in (near, far)]
    assert heights[0] - heights[1] == pytest.approx(5 * 4, abs=1)  # five metres, of four pixels


@needed
def test_it_is_a_vector_environment(make):
    upomdp = make(STILL)
    seen, info = upomdp.reset(seed=0, options={"theta": [[-1, -1], [1, 1]]})
    assert seen.shape == (2, 3) and seen.dtype == np.float32
    np.testing.assert_allclose(seen[:, 2], [5, 10])
    assert not info["replaced"].any()
    assert upomdp.describe([[-1, 0]]) == [{"speed": 1.0, "other.position": 7.5}]


@needed
def test_a_process_that_dies_is_replaced_and_its_episode_repeated(make):
    upomdp, same = make(STILL), make(STILL)
    for each in (upomdp, same):
        each.reset(seed=3)
        played(each, 5)
    os.kill(upomdp.workers[1].pid, signal.SIGKILL)
    np.testing.assert_array_equal(played(upomdp, 5, 1), played(same, 5, 1))


@needed
def test_a_process_that_hangs_is_replaced(make, monkeypatch):
    monkeypatch.setattr(scenic3.vector_env, "STEP_SECONDS", 0.0)
    monkeypatch.setattr(scenic3.vector_env, "BEGIN_SECONDS", 5.0)
    upomdp, same = make(STILL), make(STILL)
    for each in (upomdp, same):
        each.reset(seed=3)
    os.kill(upomdp.workers[0].pid, signal.SIGSTOP)
    np.testing.assert_array_equal(played(upomdp, 3), played(same, 3))


@needed
def test_a_state_goes_on_to_the_same_numbers(make):
    upomdp, same = make(STILL), make(STILL)
    upomdp.reset(seed=3)
    played(upomdp, 7)
    state = pickle.loads(pickle.dumps(upomdp.get_state()))
    same.set_state(state)
    np.testing.assert_array_equal(played(upomdp, 40, 1), played(same, 40, 1))


@needed
def test_a_mistake_tells_the_level(make):
    upomdp = make(STILL)
    upomdp.role.mistaken = True
    upomdp.reset(seed=3)
    where = r"failed after 1 steps \(theta \[.*\], seed \d+\): RuntimeError: my mistake\n.*in act"
    with pytest.raises(LevelError, match=re.compile(where, re.DOTALL)):
        upomdp.step(np.zeros((2, 1)))


@needed
def test_what_is_drawn_outside_changes_nothing(load):
    program = load(STILL)
    simulator = program.scenario.getSimulator()

    def run(noise):
        episode = scenic3.Episode(program.scene(np.zeros(2), 1), simulator, Pusher(), 1)
        seen = [episode.begin()]
        for _ in range(10):
            noise()
            seen.append(episode.step([1.0])[0])
        episode.close()
        return np.array(seen)

    before = random.getstate()
    first = run(lambda: None)
    assert random.getstate() == before
    np.testing.assert_array_equal(first, run(random.random))


@needed
def test_inspect_shows_what_scenic_reads(load, capsys):
    from experiments.__main__ import main

    path = load(DRIVE).file
    assert main(["inspect", path, "--engine", "scenic3"]) == 0
    told = capsys.readouterr().out
    assert "D = 2 free parameters" in told and "100.0% of 512" in told and "Wander" in told
    assert "drawn from the level's seed: ego.color, other.color" in told
    assert main(["inspect", path, "--engine", "scenic3", "--show", "scenes", "--theta", "0", "1"]) == 0
    assert "10.00" in capsys.readouterr().out
    Path(path).write_text("ego = new Nothing")
    assert main(["inspect", path, "--engine", "scenic3"]) == 1
    assert "Scenic refuses it" in capsys.readouterr().err


@needed
def test_plr_and_paired_train_on_it(make):
    import ued

    for method, config in ((ued.PLR, ued.PLRConfig()), (ued.Paired, ued.PairedConfig())):
        trained = method(make(STILL), ued.PPOConfig(num_steps=8, hidden_size=8), config, seed=0)
        for _ in range(3):
            trained.update()
        assert trained.env_steps >= 48
