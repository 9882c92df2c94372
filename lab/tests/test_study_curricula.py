"""`python -m lab.studies curricula`, `tuning`: the settings of each run, and the held-out games."""

import math
import re

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from lab.studies import budgets, curricula_study, rows, tables
from lab.studies.__main__ import STUDIES, main
from lab.studies.curricula import COMPARISONS
from lab.studies.curricula_study import CurriculaStudy, CurriculaStudyConfig
from lab.studies.measuring import HELD_OUT, measure_variant
from lab.studies.runs import Places
from regista.experiments.pictures import plots
from regista.experiments.run import arguments
from regista.experiments.run import results as estimate
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import find_minigame
from tests.experiments.test_limits import numbers_of
from tests.floors import ROOT
from ued.config import bounds_of

SHORT = ["--total-env-steps", "64", "--num-envs", "4", "--num-steps", "8", "--episodes", "4"]


@pytest.fixture
def here(begun, tmp_path):
    """Return the command line, and the names of the runs that it has begun."""
    words = ["curricula", "--games", "1v1Restricted", "--variants", "dr", "accel", "--seeds", "1", *SHORT]
    return [*words, "--out", str(tmp_path)], begun


@pytest.mark.long
def test_variants_are_trained_and_played_on_held_out_scenes_and_kept_in_small_tables(here, tmp_path, capsys):
    words, begun = here
    assert main(words) == 0
    assert begun == ["1v1Restricted-dr-features-30", "1v1Restricted-accel-features-30"]
    accel = RunFolder.open(tmp_path / "curricula" / begun[1]).config
    chosen = COMPARISONS["curricula"].variants["accel"].settings
    assert (accel.method, accel.accel.score) == ("accel", chosen["accel.score"])
    assert (accel.num_envs, accel.eval_every, accel.env.rewards) == (4, 6, "scoring")
    measured = rows.load(tmp_path / "results" / "curricula.csv")
    assert {row.scene for row in measured} == {"train", *(f"{HELD_OUT}{label}" for label in ("in", "near", "clear"))}
    assert {row.episodes for row in measured} == {4}
    curve = rows.load(tmp_path / "results" / "curricula_curves.csv", rows.Point)
    assert [point.env_steps for point in curve if point.agent == "dr"] == [32, 64]
    assert all(0 <= point.success <= 1 for point in curve)
    shown = capsys.readouterr().out
    assert "**1v1Restricted**\n\n| method | " in shown and "| held-out mean | minus dr | runs | env steps |" in shown
    assert "Success on test scenes, minus dr" in shown
    for path in (tmp_path / "curricula").rglob("*.pt"):
        path.unlink()  # on another machine, only the tables exist
    words[words.index("--seeds") + 1] = "2"
    assert main(words) == 0
    assert begun[2:] == ["1v1Restricted-dr-features-31", "1v1Restricted-accel-features-31"]
    assert set(measured) < set(rows.load(tmp_path / "results" / "curricula.csv"))


@pytest.mark.long
@pytest.mark.parametrize(
    ("study", "game", "scenes"),
    [
        ("curricula", "ChoosePassing", {"held out, top blocked", "held out, bottom blocked"}),  # has no other scenes
        ("tuning", "1v1Restricted", {"easy", "medium", "hard"}),  # held-out scenes are left alone
        ("tuning", "ChoosePassing", set()),  # its test scenes are those of final tables
    ],
)
def test_scenes_that_are_played(begun, tmp_path, study, game, scenes):
    name = next(iter(COMPARISONS[study].variants))
    words = [study, "--games", game, "--variants", name, "--seeds", "1", *SHORT]
    assert main([*words, "--out", str(tmp_path)]) == 0
    assert {row.scene for row in rows.load(tmp_path / "results" / f"{study}.csv")} == {"train", *scenes}
    curves = tmp_path / "results" / f"{study}_curves.csv"
    assert bool(rows.load(curves, rows.Point)) == bool(scenes)


def test_seeds_of_final_tables_are_in_no_trial_and_only_the_study_itself_is_published():
    first = {name: next(CurriculaStudy(name, CurriculaStudyConfig(), {}).planned()).seed for name in COMPARISONS}
    assert first == {"curricula": 30, "tuning": 1000}
    for config, typed in (
        (CurriculaStudyConfig(publish=True, first_seed=7), {}),
        (CurriculaStudyConfig(publish=True, seeds=11), {}),
        (CurriculaStudyConfig(publish=True, episodes=20), {}),
        (CurriculaStudyConfig(publish=True), {"ppo.gamma": 0.9}),
    ):
        with pytest.raises(UsageError, match=r"--(first-seed|seeds|episodes|gamma) it.*leave out --publish"):
            CurriculaStudy("curricula", config, typed).check_published()
    with pytest.raises(UsageError, match=r"no variant 'pared'.*did you mean 'paired'"):
        list(CurriculaStudy("curricula", CurriculaStudyConfig(variants=("dr", "pared")), {}).planned())


def test_each_method_has_as_many_tuning_runs_and_its_settings_are_among_them():
    tuned = COMPARISONS["tuning"]
    counts = dict.fromkeys(COMPARISONS["curricula"].variants, 0)
    for variant in tuned.variants.values():
        counts[variant.method] += 1
    assert set(counts.values()) == {6}
    tried = [variant.settings for variant in tuned.variants.values()]
    for name, variant in COMPARISONS["curricula"].variants.items():
        assert variant.settings in tried, name


def test_what_is_compared_has_the_best_settings_of_the_stored_tuning():
    tried = COMPARISONS["tuning"]
    stored = rows.load(rows.RESULTS / "tuning.csv")
    assert {row.agent for row in stored} == set(tried.variants) and {row.seed for row in stored} == {1000}
    for method, name in tables.best_settings(stored).items():
        assert COMPARISONS["curricula"].variants[method].settings == tried.variants[name].settings, method
    without = {row.game for row in stored if not find_minigame(row.game).held_out}
    assert without and {row.scene for row in stored if row.game in without} == {"train"}


@pytest.mark.long
def test_every_variant_is_a_run_that_can_be_begun(tmp_path):
    for name in COMPARISONS:
        study = CurriculaStudy(name, CurriculaStudyConfig(out=tmp_path, seeds=1), {})
        for plan in study.planned():
            config = study.open(plan).config
            assert config.seed == plan.seed and config.eval_every * 10 == config.total_env_steps


@pytest.mark.slow
def test_gains_are_over_whole_runs_of_the_same_scenes():
    def row(agent, seed, scene, scored):
        return rows.Row("g", agent, "c", scene, seed, 9, 100, scored / 100, 0.5, scored, 0, 5.0, 9.5 + seed, "", "1")

    measured = [
        row(agent, seed, scene, scored)
        for agent, base in (("dr", 20), ("accel", 60))
        for seed in range(5)
        for scene, scored in (("held out, a", base + seed), ("held out, b", base + 10 + seed), ("train", 99))
    ]
    head, dr, accel = tables.success_table(measured, "curricula")
    assert head == ["method", "train", "held out, a", "held out, b", "held-out mean", "minus dr", "runs", "env steps"]
    assert dr[2].startswith("22% [") and dr[4].startswith("27% [") and dr[5:] == ["", "5", "9"]
    assert accel[4].startswith("67% [") and accel[5].startswith("+40 [+3") and accel[5].endswith("] *")
    text = tables.tables(measured, "curricula")
    assert (
        text.startswith("**g**\n\n| method |")
        and "simulator version 1; `python -m lab.studies.tables curricula`" in text
    )
    assert "\n\nMarks: * survives Holm's correction at 5% over the one difference of this table" in text
    assert " 5 runs each: differences under 7 points cannot be detected" in text


def test_games_stand_in_the_order_of_the_study_and_many_scenes_are_one_column():
    def row(game, scene):
        return rows.Row(game, "dr", "c", scene, 30, 9, 20, 0.5, 0.5, 10, 0, 5.0, 9.5, "", "1")

    few = [row("1v1Free", scene) for scene in ("held out, in", "train")]
    many = [row("1v1Restricted", scene) for scene in (*(f"held out, {k}" for k in range(7)), "train")]
    text = tables.tables(few + many, "curricula")
    assert re.findall(r"^\*\*(.+)\*\*$", text, re.M) == ["1v1Restricted", "1v1Free"]
    assert "| method | train | held-out mean of 7 | minus dr |" in text
    assert "| method | train | held out, in | held-out mean | minus dr |" in text


@pytest.mark.slow
def test_a_study_that_was_killed_keeps_each_finished_run(here, tmp_path, monkeypatch):
    words, begun = here

    def killed(run, agent, *others):
        if agent == "accel":
            raise KeyboardInterrupt
        return measure_variant(run, agent, *others)

    monkeypatch.setattr(curricula_study, "measure_variant", killed)
    assert main(words) == 130
    table = tmp_path / "results" / "curricula.csv"
    before = rows.load(table)
    assert {row.agent for row in before} == {"dr"} and len(begun) == 2
    monkeypatch.setattr(curricula_study, "measure_variant", measure_variant)
    monkeypatch.setattr(RunFolder, "finished", lambda run: run.env_steps() >= 64)  # pictures are not drawn here
    assert main(words) == 0
    assert len(begun) == 2  # the other run only had to be played
    assert {row.agent for row in rows.load(table)} == {"dr", "accel"} and set(before) < set(rows.load(table))


def points(agent, base):
    """Return curves of five runs on two games that end at `base` + 1% per later seed, with other evaluation steps."""
    steps = {0: 8, 50: 49, 100: 100}
    return [
        rows.Point(game, agent, seed, steps[at] + (agent == "sfl"), 1.0, at / 100 * (base + 0.01 * seed), "1")
        for seed in range(5)
        for game in ("a", "b")
        for at in steps
    ]


@pytest.mark.slow
@pytest.mark.drawn
def test_differences_by_budget_are_over_whole_runs(tmp_path):
    both = points("dr", 0.2) + points("sfl", 0.6)
    half, whole = (budgets.gain(both, "sfl", "dr", part) for part in (0.5, 1.0))
    assert half[0] == pytest.approx(0.2) and whole[0] == pytest.approx(0.4)
    assert whole.low > 0.3 and whole.excludes_zero
    partial = [point for point in both if (point.seed, point.game) != (4, "b")]
    assert budgets.rates(partial, "dr", 1.0).shape == (4, 2)
    text = budgets.section(both)
    assert text.startswith("| method | 10 steps | 30 steps |") and "| sfl | " in text and "over 5 runs" in text
    assert "5 runs. Marks: * survives" in text and "excludes 0. 5 runs each: differences under " in text
    assert text.endswith("Measured on simulator version 1; `python -m lab.studies.tables curricula`.")
    budgets.draw(both, tmp_path / "curves.png")
    with Image.open(tmp_path / "curves.png") as picture:
        assert {(r, g, b) for _, (r, g, b, *_) in picture.convert("RGB").getcolors(10**6)} >= set(colors("dr", "sfl"))


def test_budgets_of_a_study_that_goes_on_are_those_of_games_that_all_methods_have():
    both = points("dr", 0.2) + points("sfl", 0.6)
    begun = [point for point in both if point.agent == "dr" or point.game == "a"]
    assert "on test scenes, minus dr, in percentage points" in budgets.section(begun)  # of one game
    assert budgets.section(points("dr", 0.2)) == ""
    assert "  " not in budgets.section([point for point in both if point.seed == 0])  # no marks, no sentence
    apart = [point for point in both if (point.agent, point.game) in (("dr", "a"), ("sfl", "b"))]
    assert budgets.section(apart) == ""


@pytest.mark.slow
def test_at_equal_student_steps_the_first_method_had_as_many_as_the_other_learned_from():
    both = [point._replace(trained_steps=point.env_steps // 2) for point in points("sfl", 0.6)] + points("dr", 0.2)
    assert budgets.share_learned(both, "sfl") == pytest.approx(0.5, abs=0.01)
    equal = budgets.at_equal_student_steps(both, "sfl", "dr", 0.5)
    assert equal[0] == pytest.approx(0.6 - 0.1 + 0.01)  # the end of one method, the middle of the other
    text = budgets.section(both)
    assert "| learns from | equal student steps |" in text and "| 50% | +51 [" in text
    assert "minus dr after as many as the method's tested student learned from" in text
    assert "equal student steps" not in budgets.section(points("sfl", 0.6) + points("dr", 0.2))  # older rows


def test_curves_begin_with_the_first_evaluation_and_axes_are_labeled(tmp_path, monkeypatch):
    from matplotlib import pyplot as plt

    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, path: drawn.append(figure))
    budgets.draw(points("dr", 0.2), tmp_path / "curves.png")
    panels = drawn[0].axes[:2]
    assert all(axes.get_xlabel() == "simulated steps, all students" for axes in panels)
    curves = [line.get_xdata() for axes in panels for line in axes.lines if len(line.get_xdata()) > 1]
    assert len(curves) == 2 and all(steps[0] == pytest.approx(10) for steps in curves)
    assert panels[0].get_ylim() == (0, 1) and panels[0].get_ylabel() == "success on test scenes"
    plt.close(drawn[0])


@pytest.mark.slow
@pytest.mark.drawn
@pytest.mark.parametrize("games", range(1, 8))
def test_the_picture_fits_any_number_of_games(games, tmp_path, monkeypatch):
    """Intervals stand side by side behind the curves, without ticks; no row of the legend is nearly empty."""
    from matplotlib import pyplot as plt

    drawn, names = [], ("dr", "paired", "robust_plr", "accel", "sfl")
    monkeypatch.setattr(plots, "save", lambda figure, path: drawn.append(figure))
    both = [point for name in names for point in points(name, 0.2) if point.game == "a"]
    budgets.draw([point._replace(game=f"game {k}") for k in range(games) for point in both], tmp_path / "a.png")
    shown = [axes for axes in drawn[0].axes if axes.get_visible()]
    assert len(shown) == games
    for axes in shown:
        ends = [
            line.get_xdata()[0] for line in axes.lines if line.get_marker() != "None" and len(line.get_xdata()) == 1
        ]
        assert len(set(ends)) == 5 and min(ends) > 101 >= max(axes.get_xticks())
        assert axes.get_xlim()[1] > max(ends)
    legend = drawn[0].legends[0]
    rows = -(-len(legend.texts) // legend._ncols)
    assert len(legend.texts) == 7 and legend._ncols == -(-7 // rows)  # with fewer columns, there would be more rows
    plt.close(drawn[0])


def colors(*methods):
    """Return the colors of methods as pixels."""
    return [tuple(round(255 * part) for part in to_rgb(plots.color(method))) for method in methods]


def test_what_is_published_goes_into_the_repository():
    assert Places.of(None, "RESULTS.md") == (ROOT / "lab" / "studies" / "results", ROOT / "RESULTS.md")


def played(game, agent, seed, scene, scored):
    """Return a row of 100 episodes."""
    return rows.Row(game, agent, "c", scene, seed, 9, 100, scored / 100, 0.5, scored, 0, 5.0, 9.5, "", "1")


@pytest.mark.slow
def test_the_summary_has_a_row_for_each_game_and_one_of_all_games():
    measured = [
        played(game, agent, seed, scene, base + seed)
        for game, agent, base in (("a", "dr", 20), ("a", "sfl", 60), ("b", "dr", 40), ("b", "sfl", 40))
        for seed in range(5)
        for scene in ("held out, x", "held out, y", "train")
    ]
    text = tables.summary(measured)
    head, _, *shown = [line for line in text.splitlines() if line.startswith("|")]
    assert head == "| game | dr | sfl minus dr |"
    assert [row.split("|")[1].strip() for row in shown] == ["a", "b", "**all games**"]
    assert "| +40 [" in shown[0] and "| 0 [" in shown[1].replace("+0", "0") and "| +20 [" in shown[2]
    assert "* survives Holm's correction at 5% over the 3 differences" in text and "over 5 runs" in text
    seeds = tables.shared_seeds(
        [row for row in measured if (row.game, row.seed) != ("a", 2)], ["a", "b"], ["dr", "sfl"]
    )
    assert seeds == {0, 1, 3, 4}
    few = tables.summary([row for row in measured if (row.game, row.agent) != ("b", "sfl")])
    assert "all games" not in few and "| sfl minus dr |" in few.splitlines()[0]


@pytest.mark.slow
def test_games_with_few_runs_are_not_part_of_means_over_games():
    measured = [
        played(game, agent, seed, "held out, x", base + seed)
        for game, runs in (("a", 5), ("b", 5), ("c", 2))
        for agent, base in (("dr", 20), ("sfl", 60 if game == "a" else 20))
        for seed in range(runs)
    ]
    text = tables.summary(measured)
    *_, third, mean = [line for line in text.splitlines() if line.startswith("|")]
    assert "95% bootstrap intervals over 5 runs. Fewer than 5 runs, so no interval: c." in text
    assert third == "| c | 20% | +0 |"  # two runs have no interval
    assert mean.startswith("| **2 games of 5 runs** | 22% [") and "| +20 [" in mean
    curves = [*points("dr", 0.2), *points("sfl", 0.6)]
    begun = [point._replace(game="c", success=0.0) for point in curves if point.game == "a" and point.seed < 2]
    assert budgets.section([*curves, *begun]) == budgets.section(curves)


def test_a_summary_without_rows_or_of_another_study_is_refused(tmp_path, capsys):
    assert tables.main(["curricula", "--summary", "--results", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"{tmp_path}/curricula.csv has no rows.\n"
    with pytest.raises(UsageError, match="--summary is of curricula, not of tuning"):
        tables.main(["tuning", "--summary"])


def test_means_over_games_weigh_games_alike_however_many_scenes_they_have():
    rates = [np.array([[0.2, 0.4]]), np.array([[0.9]])]  # of the same run
    both = tables.over_games([estimate.Scores(mine, np.full_like(mine, 0.1)) for mine in rates])
    assert both.rates.tolist() == [[pytest.approx(0.3), 0.9]]
    assert both.errors.tolist() == [[pytest.approx(0.1 / 2**0.5), 0.1]]


def test_the_best_setting_of_each_method_is_bold_by_scenes_that_no_final_table_has():
    names = list(COMPARISONS["tuning"].variants)[:2]
    measured = [
        *(
            played("1v1Restricted", names[0], 1000, scene, n)
            for scene, n in (("easy", 50), ("hard", 70), ("train", 99))
        ),
        *(played("1v1Restricted", names[1], 1000, scene, n) for scene, n in (("easy", 70), ("hard", 90), ("train", 1))),
        *(played("ChoosePassing", name, 1000, "train", n) for name, n in zip(names, (70, 60), strict=True)),
    ]
    lines = tables.tables(measured, "tuning").splitlines()
    assert lines[0] == "| method, setting | 1v1Restricted | ChoosePassing | mean |"
    assert lines[2:4] == [f"| {names[0]} | 60% | 70% | 65.0% |", f"| **{names[1]}** | 80% | 60% | 70.0% |"]


def test_the_games_of_a_study_are_trained_as_its_help_says(capsys):
    cases = STUDIES["curricula"].others("curricula")
    assert list(cases) == ["for the games of the study but AcademyLadder", "for AcademyLadder"]
    found = [other for games in cases.values() for other in games]
    planned = CurriculaStudy("curricula", CurriculaStudyConfig(seeds=1, variants=("dr",)), {}).planned()
    for plan, other in zip(planned, found, strict=True):
        settings = {path: value for path, value in plan.settings.items() if path not in ("method", "eval_every")}
        assert arguments.replace_paths(CurriculaStudyConfig().train, settings) == other.train
    for study, stated in (
        ("curricula", "128; 16 for the games of the study but AcademyLadder"),
        ("single", "128; 16 with --preset thesis"),
    ):
        with pytest.raises(SystemExit):
            main([study, "--help"])
        assert f"(default {stated})" in re.sub(r"\s+", " ", capsys.readouterr().out)


@pytest.mark.parametrize("name", STUDIES)
def test_every_number_of_every_study_has_bounds(name):
    for number in numbers_of(STUDIES[name].config()):
        least, most = bounds_of(number.item.metadata)
        assert math.isfinite(least) and math.isfinite(most) and least < most, number.flag
