"""Curricula by hand: plans as text, regions in own units, criteria that hold, and runs that resume."""

import numpy as np
import pytest

import scenic_lite
from regista.envs.football.scenic.domain import FOOTBALL
from tests.ued.test_methods import PPO, frontier, numbers
from ued import DR, Choice, Integer, Lessons, LessonsConfig, LogRange, Range, Seeds, ThetaSpace
from ued.core import checkpoint
from ued.core.level_space import ThetaError
from ued.lesson_config import Criterion, lesson_of
from ued.levels.budget import Budget
from ued.levels.regions import region_of
from ued.methods.lessons import LessonCurriculum

KINDS = {
    "gravity": Range(5, 15),
    "mass": LogRange(0.1, 10),
    "legs": Integer(2, 6),
    "ground": Choice("grass", "ice", "mud", weights=(2, 1, 1)),
}


class Space(ThetaSpace):
    """Levels of these kinds, described in their units."""

    def __init__(self, kinds=KINDS, valid=None):
        super().__init__(kinds, valid, seed=0)

    def values(self, levels):
        return [self.theta_map.values(row) for row in levels["theta"]]


def drawn(text, space=None, count=400):
    space = space or Space()
    return space.values(region_of(space, lesson_of(text)).sample(space, count, np.random.default_rng(0), "it"))


def curriculum(plan, increments=1, window=10, total=None, space=None):
    config = LessonsConfig(plan=plan, increments=increments, window=window)
    return LessonCurriculum(space or Space(), config, 0, Budget(total=total))


def play(curriculum, success, count=10, steps=0):
    """Let `count` levels be played with this mean success; return the metrics."""
    records = curriculum.propose(count)
    records["returns"][:, 0, 0] = np.arange(count) < success * count
    curriculum.budget.spent += steps
    return curriculum.update(records)


def test_a_lesson_is_a_region_and_criteria():
    lesson = lesson_of("gravity=5..7, ground=grass|ice until success 80% or steps 1e5 or steps 20%")
    assert lesson.region == (("gravity", "5..7"), ("ground", "grass|ice"))
    assert lesson.until == (Criterion("success", 0.8), Criterion("steps", 1e5), Criterion("share", 0.2))
    assert lesson_of("all").region == lesson_of("all").until == ()


def test_levels_lie_in_the_region_in_the_parameters_own_units():
    rows = drawn("gravity=5..7, mass=1..10, legs=3..4, ground=grass|mud")
    gravity, mass = (np.array([row[name] for row in rows]) for name in ("gravity", "mass"))
    assert 5 <= gravity.min() < 5.05 and 6.95 < gravity.max() <= 7
    assert 1 <= mass.min() < 1.05 and 9.5 < mass.max() <= 10 and 0.4 < (mass < 10**0.5).mean() < 0.6  # logarithms
    assert {row["legs"] for row in rows} == {3, 4}
    grounds = [row["ground"] for row in rows]
    assert set(grounds) == {"grass", "mud"} and 0.6 < grounds.count("grass") / 400 < 0.73  # 2 to 1


def test_what_a_lesson_does_not_name_has_its_whole_range():
    rows = drawn("gravity=9.81")
    assert {round(row["gravity"], 9) for row in rows} == {9.81}
    assert {row["legs"] for row in rows} == {2, 3, 4, 5, 6} and {row["ground"] for row in rows} == {
        "grass",
        "ice",
        "mud",
    }
    middle = drawn("all=theta -0.25..0.25")
    assert all(8.75 <= row["gravity"] <= 11.25 for row in middle) and {row["legs"] for row in middle} == {2, 3, 4, 5, 6}


SIGNS = {"sky": Choice("wet, cold", "a|b", "it's", "up until now", (1, 2), "'so'"), "gravity": Range(5, 15)}


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("sky='wet, cold'", {"wet, cold"}),
        ('gravity=5..7, sky= "a|b" | it\'s until success 0.5', {"a|b", "it's"}),
        ("sky='up until now'|it's until success 0.5", {"up until now", "it's"}),
        ("sky='(1, 2)', gravity=5..7", {(1, 2)}),
        ("sky='so'", {"'so'"}),
    ],
)
def test_options_with_signs_of_the_syntax_are_quoted(text, options):
    rows = drawn(text, Space(SIGNS))
    assert {row["sky"] for row in rows} == options
    assert ("gravity" in text) == (max(row["gravity"] for row in rows) <= 7)


def test_all_does_not_widen_what_a_lesson_names():
    for text in ("all=theta 0..0, gravity=5..7", "gravity=5..7, all=theta 0..0"):
        rows = drawn(text)
        assert all(5 <= row["gravity"] <= 7 and row["mass"] == pytest.approx(1) for row in rows)


def test_seeds_and_numbered_columns_are_parameters():
    space = ThetaSpace(Seeds(100, 50), seed=0)
    levels = region_of(space, lesson_of("seed=60..62")).sample(space, 50, np.random.default_rng(0), "it")
    assert {space.theta_map.values(row)["seed"] for row in levels["theta"]} == {60, 61, 62}
    assert all(0 <= row["theta[1]"] <= 0.5 for row in drawn("theta[1]=0..0.5", Space(3)))


PROGRAM = """from scenic.simulators.gfootball.model import *
x = Range(0, 1)
y = Range(0, x)
n = Normal(0, 5)
k = DiscreteRange(1, 4)
c = Uniform("near", "far")
fall = Range(30, 5)
cut = TruncatedNormal(0, 2, -1, 3)
ego = LeftCM at Range(20, 40) @ (n + y + k + fall + cut)
"""


def test_columns_of_a_program_in_its_units():
    space = Space(scenic_lite.load(PROGRAM, FOOTBALL))
    rows = drawn("ego.x=25..30, n=-2..1, k=2..3", space)
    assert all(25 <= row["ego.x"] <= 30 and -2 <= row["n"] <= 1 and row["k"] in (2, 3) for row in rows)
    assert abs(np.mean([row["n"] for row in rows]) + 0.5) < 0.15  # nearly uniform in the middle of a normal
    for text in ("y=0.1..0.2", "y=0.7..0.9"):
        with pytest.raises(ValueError, match=r"the units of 'y' depend on other parameters; give its range as y=theta"):
            drawn(text, space)
    assert all(row["y"] <= 0.5 * row["x"] + 1e-9 for row in drawn("y=theta -1..0", space))


@pytest.mark.slow
def test_limits_are_values_of_a_lesson():
    space = Space(scenic_lite.load(PROGRAM, FOOTBALL))
    for text in ("fall=10..20", "fall=20..10", "fall=5..30", "fall=30..5", "cut=-1..3"):
        name, ends = text.split("=")
        low, high = sorted(map(float, ends.split("..")))
        values = [row[name] for row in drawn(text, space)]
        assert low <= min(values) < low + 1 and high - 1 < max(values) <= high
    assert {row["fall"] for row in drawn("fall=12", space, 20)} == {12}
    with pytest.raises(ValueError, match=r"'fall' must be a range or a value within 30\.\.5, .* got '4\.\.20'"):
        drawn("fall=4..20", space)
    with pytest.raises(ValueError, match="'n' must be") as refused:  # a normal ends at eight standard deviations
        drawn("n=-1e9..1e9", space)
    stated = str(refused.value).split("within ")[1].split(",")[0]
    assert drawn(f"n={stated}", space, 20)
    assert drawn("third=0.333333333333..0.666666666667", Space({"third": Range(1 / 3, 2 / 3)}))


WRONG = {
    "gravty=5..7": r"the lesson 'gravty=5..7': there is no parameter 'gravty' \(did you mean 'gravity'\?\); parameters "
    "are gravity, mass, legs, ground",
    "gravity=5..20": r"'gravity' must be a range or a value within 5..15, such as 5..15, got '5..20'",
    "gravity=7..5": r"'gravity' must be a range or a value within 5..15, such as 5..15, got '7..5'",
    "gravity=low": r"'gravity' must be a range or a value within 5..15, such as 5..15, got 'low'",
    "legs=2.5": r"'legs' must be integers within 2..6, such as 2..6, got '2.5'",
    "ground=sand": r"'ground' has no option 'sand'; options are grass \| ice \| mud",
    "mass=theta 0..2": r"'theta 0..2' must be a part of the range in theta",
    "all=0..1": r"'0..1' must be a part of the range in theta",
}


@pytest.mark.parametrize("text", WRONG)
def test_regions_that_do_not_fit_are_refused(text):
    with pytest.raises(ValueError, match=WRONG[text]):
        region_of(Space(), lesson_of(text))


REFUSED = {
    (): "plan must have at least one lesson",
    ("gravity=5", "all"): "the lesson 'gravity=5' never ends; all but the last need 'until CRITERION'",
    ("gravity until success 0.5", "all"): "has the region 'gravity'; a lesson is 'all', or \"NAME=VALUES",
    ("all until success 0.8",): "the last lesson, 'all until success 0.8', lasts until the end of the run",
    ("gravity=5..6, legs=2, gravity=7 until success 0.5", "all"): "has 'gravity' twice",
    ("sky=wet, cold until success 0.5", "all"): "the region 'cold'; .*; quote an option with a comma, as in sky='wet, ",
    ("all until luck 0.8", "all"): "has the criterion 'luck 0.8'; criteria are success 0.8",
    ("all until success 80", "all"): r"'success 80', which must be above 0 and at most 1 \(100%\)",
    ("all until episodes 0", "all"): "'episodes 0', which must be at least 1",
    ("all until return 50%", "all"): "has return in percent; only success and steps may be",
    ("all until success 0.5 until steps 5", "all"): "has more than one 'until'; join its criteria by 'or'",
}


@pytest.mark.parametrize("plan", REFUSED)
def test_plans_that_are_none_are_refused(plan):
    with pytest.raises(ValueError, match=REFUSED[plan]):
        LessonsConfig(plan=plan)


def test_a_region_without_a_valid_level_is_named(monkeypatch):
    space = Space(valid=lambda theta: theta[:, 0] > 0)
    assert all(row["gravity"] > 10 for row in drawn("gravity=5..12", space))
    monkeypatch.setattr("ued.levels.regions.MAX_TRIES", 5)
    with pytest.raises(
        ThetaError, match=r"no valid level found in 5 draws of the lesson 'gravity=5\.\.9 until steps 9'"
    ):
        curriculum(("gravity=5..9 until steps 9", "all"), space=space).propose(2)


def test_a_threshold_moves_on_when_enough_of_the_last_episodes_succeed():
    lessons = curriculum(("gravity=5..6 until success 0.8", "gravity=5..15"), window=20)
    assert play(lessons, 1.0)["lessons/lesson"] == 1  # fewer episodes than the window
    assert play(lessons, 0.5) == {"lessons/lesson": 1.0, "lessons/progress": 0.0, "lessons/success": 0.75}
    assert play(lessons, 1.0)["lessons/lesson"] == 1
    assert play(lessons, 1.0) == {"lessons/lesson": 1.0, "lessons/progress": 0.0, "lessons/success": 1.0}  # as played
    assert lessons.lesson == 1 and play(lessons, 1.0)["lessons/lesson"] == 2
    assert max(row["gravity"] for row in lessons.space.values(lessons.propose(200)["level"])) > 14


def test_a_threshold_widens_a_range_by_and_by():
    lessons = curriculum(("gravity=10 until return 0.5", "gravity=5..15"), increments=5)
    for part in range(5):
        ends = lessons.region.low[0], lessons.region.high[0]
        assert ends == pytest.approx((-part / 5, part / 5))
        assert play(lessons, 0.4)["lessons/progress"] == part / 5
        assert play(lessons, 0.6)["lessons/progress"] == part / 5
    assert lessons.lesson == 1 and (lessons.region.low[0], lessons.region.high[0]) == (-1, 1)


def test_steps_make_a_linear_schedule():
    lessons = curriculum(("gravity=5 until steps 50%", "gravity=15"), increments=100, total=1000)
    for spent in range(0, 500, 50):
        assert lessons.region.low[0] == lessons.region.high[0] == pytest.approx(-1 + spent / 250, abs=0.021)
        play(lessons, 0.0, steps=50)
    assert lessons.lesson == 1 and lessons.began == 500


def test_results_of_an_earlier_part_do_not_count_for_a_later_one():
    lessons = curriculum(("legs=2 until episodes 10", "legs=3 until success 0.5", "all"))
    late = lessons.propose(10)
    late["returns"][:, 0, 0] = 1.0
    play(lessons, 0.0)
    assert lessons.lesson == 1
    lessons.update(late)
    assert lessons.lesson == 1 and not len(lessons.recent)


def test_a_share_needs_the_length_of_the_run():
    with pytest.raises(ValueError, match="'all until steps 20%' is a share of the run, whose length is unknown"):
        curriculum(("all until steps 20%", "all"))


PLAN = LessonsConfig(
    plan=("length0=0..1, length1=0..1, block=0 until success 0.2 or steps 40%", "all"), increments=4, window=20
)


@pytest.mark.slow
def test_it_resumes_bit_for_bit_in_the_middle_of_a_plan(tmp_path):
    method = Lessons(frontier(), PPO, PLAN, 0, env_steps=5000)
    while not method.curriculum.stage:
        method.update()
    assert method.curriculum.stage < 4
    checkpoint.save(tmp_path / "c.pt", method.state_dict())
    resumed = Lessons(frontier(), PPO, PLAN, 7, env_steps=5000)
    resumed.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    for _ in range(6):
        one, other = numbers(method.update()), numbers(resumed.update())
        assert one.keys() == other.keys()
        np.testing.assert_array_equal(list(one.values()), list(other.values()))
    assert method.curriculum.lesson == 1


@pytest.mark.slow
def test_the_plan_of_all_levels_is_domain_randomization():
    """But for the stream that draws them."""
    method = Lessons(frontier(), PPO, LessonsConfig(plan=("all",)), 0)
    theta = np.concatenate([(method.update(), method.last.theta)[1] for _ in range(5)])
    plain = DR(frontier(), PPO, seed=0)
    other = np.concatenate([(plain.update(), plain.last.theta)[1] for _ in range(5)])
    assert np.abs(theta.mean(0) - other.mean(0)).max() < 0.2 and np.abs(theta.std(0) - other.std(0)).max() < 0.1


def test_families_are_refused():
    from tests.ued.test_families import Words, make

    with pytest.raises(ValueError, match="can be sampled and mutated, but not chosen by theta"):
        Lessons(make(Words), PPO)
