"""`python -m lab.studies curricula`, `rare`, `ablations`: what is trained with which settings, what is held out."""

import math
import re

import numpy as np
import pytest

from lab.studies import rows, tables
from lab.studies.__main__ import STUDIES, main
from lab.studies.curricula import COMPARISONS
from lab.studies.curricula_study import CurriculaStudy, CurriculaStudyConfig
from lab.studies.measuring import HELD_OUT, THIRDS, thirds
from lab.studies.runs import Places
from regista.experiments.run import arguments
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder
from tests.experiments.test_limits import numbers_of
from tests.floors import ROOT
from ued.config import bounds_of
from ued.evaluation import Evaluation

SHORT = ["--total-env-steps", "64", "--num-envs", "4", "--num-steps", "8", "--episodes", "4", "--levels", "12"]


@pytest.fixture
def here(begun, tmp_path):
    """Return what is typed, and the names of the runs that it has begun."""
    words = ["curricula", "--games", "1v1Restricted", "--variants", "dr", "plr", "--seeds", "1", *SHORT]
    return [*words, "--out", str(tmp_path)], begun


@pytest.mark.slow
def test_arms_are_trained_and_played_on_held_out_levels_and_kept_in_small_tables(here, tmp_path, capsys):
    words, begun = here
    assert main(words) == 0
    assert begun == ["1v1Restricted-dr-features-0", "1v1Restricted-plr-features-0"]
    plr = RunFolder.open(tmp_path / "curricula" / begun[1]).config
    assert (plr.method, plr.plr.score, plr.plr.episodes_per_level) == ("plr", "learnability", 4)
    assert (plr.num_envs, plr.eval_every, plr.env.rewards) == (4, 6, "scoring")
    measured = rows.load(tmp_path / "results" / "curricula.csv")
    assert {row.scene for row in measured} >= {"train", "easy", "medium", "hard", *THIRDS}
    assert sum(row.episodes for row in measured if row.agent == "dr" and row.scene in THIRDS) == 12 * 4
    curve = rows.load(tmp_path / "results" / "curricula_curves.csv", rows.Point)
    assert [point.env_steps for point in curve if point.agent == "dr"] == [32, 64]
    shown = capsys.readouterr().out
    assert "**1v1Restricted**\n\n| method | " in shown and "| held-out mean | minus dr | runs | env steps |" in shown
    for path in (tmp_path / "curricula").rglob("*.pt"):
        path.unlink()  # another machine: the tables alone are there
    words[words.index("--seeds") + 1] = "2"
    assert main(words) == 0
    assert begun[2:] == ["1v1Restricted-dr-features-1", "1v1Restricted-plr-features-1"]
    assert set(measured) < set(rows.load(tmp_path / "results" / "curricula.csv"))


@pytest.mark.slow
def test_where_what_is_hard_is_rare_the_games_held_out_scenes_count(begun, tmp_path, capsys):
    words = ["rare", "--games", "1v1Rare", "--variants", "dr", "paired", "--seeds", "1", *SHORT]
    assert main([*words, "--out", str(tmp_path)]) == 0
    assert begun == ["1v1Rare-dr-features-10", "1v1Rare-paired-features-10"]
    measured = rows.load(tmp_path / "results" / "rare.csv")
    held_out = {f"{HELD_OUT}{label}" for label in ("in", "clear")}
    assert {row.scene for row in measured if row.scene.startswith(HELD_OUT)} == held_out
    shown = capsys.readouterr().out
    assert "**1v1Rare**" in shown and "| held out, clear | held out, in |" in shown


def test_seeds_of_final_tables_are_in_no_trial_and_only_the_study_itself_is_published():
    first = {name: next(CurriculaStudy(name, CurriculaStudyConfig(), {}).planned()).seed for name in COMPARISONS}
    assert first == {"curricula": 0, "rare": 10, "ablations": 1000, "tuning": 1000}
    for config, typed in (
        (CurriculaStudyConfig(publish=True, first_seed=7), {}),
        (CurriculaStudyConfig(publish=True), {"ppo.gamma": 0.9}),
    ):
        with pytest.raises(UsageError, match=r"--(first-seed|gamma).*leave out --publish"):
            CurriculaStudy("curricula", config, typed).run()
    with pytest.raises(UsageError, match=r"no variant 'pared'.*did you mean 'paired'"):
        list(CurriculaStudy("curricula", CurriculaStudyConfig(variants=("dr", "pared")), {}).planned())


def test_what_was_searched_on_a_game_is_set_on_that_game_alone():
    config = CurriculaStudyConfig(variants=("tuned dr", "dr"), seeds=1)
    planned = {(plan.game, plan.agent): plan.settings for plan in CurriculaStudy("rare", config, {}).planned()}
    for game, settings in COMPARISONS["rare"].variants["tuned dr"].tuned.items():
        assert planned[game, "tuned dr"] == planned[game, "dr"] | settings != planned[game, "dr"]


def test_every_variant_is_a_run_that_can_be_begun(tmp_path):
    for name in COMPARISONS:
        study = CurriculaStudy(name, CurriculaStudyConfig(out=tmp_path, seeds=1), {})
        for plan in study.planned():
            config = study.open(plan).config
            assert config.seed == plan.seed and config.eval_every * 10 == config.total_env_steps


def test_held_out_levels_are_told_by_thirds_of_their_first_parameter():
    levels = np.zeros(4, [("theta", np.float64, (2,))])
    levels["theta"][:, 0] = [-1.0, -0.2, 0.4, 1.0]
    level = np.array([0, 1, 2, 3, 3])
    success = np.array([1, 0, 0, 1, 1])
    parts = thirds(Evaluation(success * 1.0, success, np.full(5, 9), level, levels, 45))
    assert [parts[name].success.tolist() for name in THIRDS] == [[1], [0], [0, 1, 1]]


def test_gains_are_over_whole_runs_of_the_same_scenes():
    def row(agent, seed, scene, scored):
        return rows.Row("g", agent, "c", scene, seed, 9, 100, scored / 100, 0.5, scored, 0, 5.0, 9.5 + seed, "", "1")

    measured = [
        row(agent, seed, scene, scored)
        for agent, base in (("dr", 20), ("plr", 60))
        for seed in range(5)
        for scene, scored in ((THIRDS[0], base + seed), (THIRDS[2], base + 10 + seed), ("train", 99))
    ]
    head, dr, plr = tables.success_table(measured, "curricula")
    assert head == ["method", THIRDS[0], THIRDS[2], "train", "held-out mean", "minus dr", "runs", "env steps"]
    assert dr[1].startswith("22% [") and dr[4].startswith("27% [") and dr[5:] == ["", "5", "9"]
    assert plr[4].startswith("67% [") and plr[5].startswith("+40% [+3") and plr[5].endswith("] *")
    text = tables.tables(measured, "curricula")
    assert (
        text.startswith("**g**\n\n| method |")
        and "simulator version 1; `python -m lab.studies.tables curricula`" in text
    )
    assert "\n\nMarks: * survives Holm's correction at 5% over the one difference of this table" in text
    assert " 5 runs each: differences under 7 points cannot be seen" in text


def test_what_is_published_goes_into_the_repository():
    assert Places.of(None, "RESULTS.md") == (ROOT / "lab" / "studies" / "results", ROOT / "RESULTS.md")


def test_the_games_of_a_study_are_trained_as_its_help_says(capsys):
    found = STUDIES["curricula"].others("curricula")["for the games of the study"]
    planned = CurriculaStudy("curricula", CurriculaStudyConfig(seeds=1, variants=("dr",)), {}).planned()
    for plan, other in zip(planned, found, strict=True):
        settings = {path: value for path, value in plan.settings.items() if path not in ("method", "eval_every")}
        assert arguments.replace_paths(CurriculaStudyConfig().train, settings) == other.train
    for study, stated in (
        ("curricula", "128; 16 for the games of the study"),
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
