"""Tables of an evaluation: intervals, differences, marks, and what is said of them."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from regista.experiments.run.report import DIFFERENCES, Report
from regista.experiments.run.results import (
    LevelResult,
    Result,
    Scores,
    advantage,
    align_within,
    chance_of_better,
    goal_rate,
    iqm_score,
    iqm_stratified,
    level_cvar,
    level_rate,
    mean_return,
    mean_score,
    summarize_levels,
)
from regista.experiments.run.significance import difference, points
from regista.experiments.run.table import read_rows
from ued.core.level_space import level_dtype
from ued.core.task import TRAINING_SCENE
from ued.evaluation import Evaluation
from ued.statistics import Difference


def row(method, seed, goals, scene="easy", trained=(1000, 10)):
    return Result(method, seed, scene, 100, goals / 100, 0.4, goals, 30.0, *trained)


def test_a_single_run_has_wilson_and_several_have_the_bootstrap():
    single = goal_rate([row("dr", 0, 50)])
    assert single == pytest.approx((0.5, 0.4038, 0.5962), abs=1e-3)
    several = goal_rate([row("dr", seed, goals) for seed, goals in enumerate((34, 37, 40, 43, 46))])
    reach = 2.776 * 0.0474 / 5**0.5  # Student's t, and a little more for luck
    assert several == pytest.approx((0.4, 0.4 - reach, 0.4 + reach), abs=0.03)
    assert mean_return([row("dr", 0, 50)]).high == pytest.approx(0.5 + 1.984 * 0.4 / 99**0.5, abs=1e-4)


def two_values(method):
    """Return two runs of a method: 36 and 44 goals of 100."""
    return [row(method, seed, goals) for seed, goals in enumerate((36, 44))]


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_fewer_than_five_values_have_no_interval(count):
    """Of two runs the smallest and the largest were once called a 95% interval; so were a run's two episodes."""
    runs = [row("dr", seed, 36 + 2 * seed) for seed in range(count)]
    few = [replace(runs[0], episodes=count, goals=1, mean_return=1 / count)]
    found = [goal_rate(few), mean_return(few), level_cvar([LevelResult("dr", 0, 10 * count, 4, 0.5, 0.2, 0.05)])]
    if count > 1:
        many = [row("paired", seed, 60) for seed in range(9)]
        levels = [LevelResult("dr", seed, 200, 4, 0.5, 0.2, 0.05) for seed in range(count)]
        found += [goal_rate(runs), mean_return(runs), advantage(many, runs), advantage(runs, many)]
        found += [level_rate(levels), level_cvar(levels)]
        scores = Scores(np.full((count, 3), 0.5), np.full((count, 3), 0.1))
        found += [mean_score(scores), iqm_score(scores), iqm_stratified(scores), chance_of_better(scores, scores)]
    for interval in found:
        assert not interval.known and np.isnan([interval.low, interval.high]).all() and interval.estimate >= -1


def test_a_table_of_two_runs_shows_no_interval_and_says_so(tmp_path):
    report = Report([*two_values("dr"), *two_values("paired")])
    text = report.text()
    table, note = text.split("[95% intervals", 1)
    assert "[" not in table and "40%" in table and "none below 5 runs, or 5 episodes" in note
    assert "[" not in note.split("\n\n")[1].split("\n[")[0]
    report.save(tmp_path)
    with open(tmp_path / "table.csv") as file:
        entries = list(csv.DictReader(file))
    assert entries and all((entry["low"], entry["high"], entry["interval"]) == ("", "", "") for entry in entries)


def test_runs_that_agree_by_chance_are_not_certain():
    for interval in (
        goal_rate([row("dr", seed, 50) for seed in range(5)]),
        mean_return([row("dr", seed, 50) for seed in range(5)]),
    ):
        assert interval.estimate == 0.5
        assert 0.03 < interval.high - interval.estimate < 0.06  # 1.96 standard errors of 500 episodes are 0.044
    always = goal_rate([row("dr", seed, 100) for seed in range(5)])
    assert 0.97 < always.low < 0.995 and always.estimate == always.high == 1.0


def test_the_advantage_of_a_better_method_is_positive():
    better = [row("paired", seed, 80 + seed) for seed in range(5)]
    worse = [row("dr", seed, 40 - seed) for seed in range(5)]
    gain = advantage(better, worse)
    assert gain.estimate == pytest.approx(0.44) and gain.low > 0.3


def two_methods():
    results = [
        row(method, seed, goals, scene)
        for method, goals in (("dr", 40), ("paired", 60))
        for seed in range(5)
        for scene in ("easy", "hard")
    ]
    return results + [row("shoot", 0, goals, scene, trained=(0, 0)) for goals, scene in ((10, "easy"), (0, "hard"))]


@pytest.mark.slow
def test_marks_tell_differences_that_survive_holm_from_others():
    """Of two other methods on two scenes: a clear difference, one that the others make doubtful, and none twice."""

    def runs(method, scene, goals):
        return [row(method, seed, goals + 4 * (seed - 2), scene) for seed in range(5)]

    places = {"dr": (40, 40), "paired": (80, 53), "plr": (40, 41)}
    results = [
        one for name, pair in places.items() for k, scene in enumerate(("a", "b")) for one in runs(name, scene, pair[k])
    ]
    report = Report(results)
    found = {(one.method, one.scene): one for one in report.entries if one.measure == "return minus first"}
    assert [found[key].mark for key in (("paired", "a"), ("paired", "b"), ("plr", "a"), ("plr", "b"))] == [
        "*",
        "†",
        "",
        "",
    ]
    doubtful = found["paired", "b"]
    assert doubtful.low > 0 and doubtful.p < 0.05 < doubtful.p_holm == pytest.approx(3 * doubtful.p)
    first, second = report.text().split("\n\n")
    assert "survives Holm's correction at 5% over the 4 differences of this table" in first and "] †" in first
    assert "over the 2 differences of this table" in second
    assert (
        "5 runs each: differences under 0.1" in first
        and "points cannot be detected reliably (power below 80%" in second
    )
    assert report.markdown().count("Holm") == 2
    assert all(np.isnan(one.p) and not one.mark for one in report.entries if one.measure not in DIFFERENCES)


def test_an_end_beside_0_shows_on_which_side_it_is():
    assert points(Difference(-0.05, -0.09, -0.0004, 0.04), "†") == "-5 [-9, -0.04] †"
    assert points(Difference(-0.05, -0.09, 0.0004, 0.06), "") == "-5 [-9, +0]"
    assert points(Difference(-0.001, -0.09, 0.09, 0.9), "") == "+0 [-9, +9]"
    assert difference(Difference(0.05, 0.001, 0.09, 0.04), "†") == "+0.05 [+0.001, +0.09] †"


def test_too_few_runs_have_no_marks_but_a_smallest_visible_difference():
    text = Report(
        [row(name, seed, 10 * seed + 20 * (name == "plr")) for name in ("dr", "plr") for seed in range(3)]
    ).text()
    assert "correction" not in text and "3 runs each: differences under 43 points cannot be detected" in text


@pytest.mark.slow
def test_the_table_has_methods_and_scenes():
    lines = [line.split("  ") for line in Report(two_methods()).text().splitlines()]
    cells = [[cell.strip() for cell in line if cell.strip()] for line in lines]
    assert cells[0] == ["method", "easy", "hard", "runs", "env_steps", "updates"]
    assert [line[0] for line in cells[2:9]] == ["dr", "goals", "paired", "goals", "− dr", "shoot", "goals"]
    assert cells[4][2].startswith("+0.60 [+0.") and cells[4][4:] == ["5", "1_000", "10"]
    assert cells[6][1].startswith("+0.20 [+0.") and cells[7][-3:] == ["1", "–", "–"]
    assert cells[8] == ["goals", "10% [6%, 17%]", "0% [0%, 4%]"]
    second = cells.index(["method", "mean", "IQM", "IQM, stratified", "mean − dr", "P(better than dr)"])
    assert cells[second + 3][-1].startswith("1.00 [0.") and cells[second + 2][0] == "dr"
    assert cells[second + 4] == ["shoot", "5%", "5%", "5%"]


@pytest.mark.slow
def test_a_table_that_is_wider_than_the_terminal_is_cut_into_blocks():
    report = Report(two_methods())
    assert report.text(10_000) == report.text()
    narrow = report.text(60)
    scenes = narrow.partition("\n[")[0]
    blocks = scenes.split("\n\n")
    assert len(blocks) > 1 and max(map(len, scenes.splitlines())) <= 60
    assert [block.split("\n")[0].split()[:2] for block in blocks[:2]] == [["method", "easy"], ["method", "hard"]]
    assert set(narrow.replace("─", "").split()) == set(report.text().replace("─", "").split())
    assert len(align_within([["method", "", "a long scene"]], 5).splitlines()) == 2  # one column at least


@pytest.mark.long
def test_a_mean_that_includes_the_training_levels_says_so():
    rows = two_methods()
    assert "mean and IQM over all scenes;" in Report(rows).text()
    training = [replace(one, scene=TRAINING_SCENE) for one in rows if one.scene == "easy"]
    assert f"over all scenes, including the {TRAINING_SCENE};" in Report([*rows, *training]).text()


@pytest.mark.slow
def test_markdown_and_csv_have_the_same_numbers(tmp_path):
    report = Report(two_methods(), [LevelResult(name, 0, 50, 4, 0.5, 0.2, 0.05) for name in ("dr", "paired", "shoot")])
    report.save(tmp_path)
    lines = (tmp_path / "table.md").read_text().splitlines()
    widths = {line.count("|") for line in lines if line.startswith("| ")}
    assert widths == {8, 9}  # 7 and 8 columns
    assert any(
        line.startswith("| paired | 60% [") and line.endswith("| 50% [43%, 57%] | 20% [6%, 34%] |") for line in lines
    )
    with open(tmp_path / "table.csv") as file:
        entries = {(row["method"], row["measure"], row["scene"]): row for row in csv.DictReader(file)}
    assert float(entries["paired", "mean minus first", ""]["estimate"]) == pytest.approx(0.2)
    assert entries["paired", "P(better)", ""]["low"] < entries["paired", "P(better)", ""]["estimate"]
    assert float(entries["shoot", "goals", "easy"]["high"]) == pytest.approx(0.1744, abs=1e-3)  # Wilson of 10 in 100
    kinds = {
        measure: entries["paired", measure, ""]["interval"] for measure in ("mean", "P(better)", "IQM, stratified")
    }
    assert list(kinds.values()) == ["bootstrap over runs", "Newcombe", "bootstrap over runs and scenes"]
    assert (entries["shoot", "goals", "easy"]["interval"], entries["shoot", "return", "easy"]["interval"]) == (
        "Wilson",
        "t",
    )
    assert len(read_rows(tmp_path / "levels.csv")) == 3


def test_scores_of_all_scenes():
    """Two runs on three scenes, by hand: the middle half of six values is three of them."""
    found = Scores(np.array([[0.0, 0.5, 1.0], [0.2, 0.6, 0.7]]), np.zeros((2, 3)))
    assert iqm_score(found).estimate == pytest.approx((0.5 * 0.2 + 0.5 + 0.6 + 0.5 * 0.7) / 3)
    assert iqm_score(found).estimate == iqm_stratified(found).estimate
    several = Scores(np.tile(found.rates, (3, 1)), np.tile(found.errors, (3, 1)))
    assert iqm_stratified(several).low < iqm_stratified(several).high
    other = Scores(np.array([[0.4], [0.4], [0.6]]) + np.zeros((3, 3)), np.zeros((3, 3)))
    assert chance_of_better(found, other).estimate == pytest.approx(2 / 3)  # both have the mean 0.5


def levels_played(goals):
    """Return an evaluation of these outcomes `[L, k]`."""
    count, each = goals.shape
    returns = goals.T.ravel().astype(float)
    levels = np.zeros(count, level_dtype(2))
    return Evaluation(returns, returns, np.ones(len(returns), int), np.arange(count * each) % count, levels, 0)


def test_the_worst_levels_are_found_by_other_episodes():
    """Ten levels, four episodes: level 0 fails in the even ones and scores in the odd ones, level 1 always fails."""
    goals = np.ones((10, 4), bool)
    goals[0, ::2] = False
    goals[1] = False
    row = summarize_levels(levels_played(goals), "dr", 3)
    assert (row.method, row.seed, row.levels, row.episodes) == ("dr", 3, 10, 4)
    assert row.goal_rate == pytest.approx(0.85)
    # by the even episodes levels 0 and 1 tie for the worst, with 1 and 0 in the odd ones; by the odd ones it is level 1
    assert row.cvar10 == pytest.approx((0.5 + 0.0) / 2)


def test_levels_of_one_and_of_several_runs():
    one = LevelResult("dr", 0, 100, 10, 0.5, 0.05, 0.05)
    assert level_rate([one]) == pytest.approx((0.5, 0.469, 0.531), abs=1e-3)
    assert level_cvar([one]) == pytest.approx((0.05, 0.0, 0.05 + 2.262 * 0.05), abs=1e-4)  # t of ten levels
    several = [replace(one, seed=seed, goal_rate=rate) for seed, rate in enumerate((0.4, 0.45, 0.5, 0.55, 0.6))]
    assert level_rate(several).low < 0.42 and level_cvar(several).estimate == pytest.approx(0.05)


@pytest.mark.parametrize("goals", [0, 8])
def test_returns_that_are_goals_have_the_interval_of_goals(goals):
    """Eight equal returns are not certain: 0 of 8 may be a third."""
    run = Result("dr", 0, "easy", 8, goals / 8, 0.0, goals, 30.0, 1000, 10)
    assert mean_return([run]) == goal_rate([run]) and mean_return([run]).high - mean_return([run]).low > 0.3


def test_runs_of_which_all_episodes_are_equal_differ_as_their_goals():
    def runs(method, goals):
        rate = goals / 50
        about = ("easy", 50, rate, (rate * (1 - rate)) ** 0.5, goals, 9.0, 9, 9)
        return [Result(method, seed, *about) for seed in range(5)]

    assert not advantage(runs("dr", 49), runs("paired", 50)).excludes_zero
