"""`regista evaluate FOLDER` evaluates all runs in a folder, grouped by method."""

import json
import shutil
from types import SimpleNamespace

import pytest

import regista
from regista.envs.football.config import FootballConfig
from regista.experiments.__main__ import main
from regista.experiments.pictures.plots import BASELINES
from regista.experiments.run import build, provenance
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import CommandError
from regista.experiments.run.evaluator import EvalScenes
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.run_folders import check_one_game, open_runs
from regista.experiments.run.table import read_rows
from tests.experiments.test_play_level import TASK

pytestmark = pytest.mark.slow

SMALL = ["--total-env-steps", "512", "--num-envs", "4", "--num-steps", "64", "--eval-every", "0", "--no-record"]
BRIEF = ["--episodes", "2", "--levels", "0", "--no-baselines"]
GAME, SCENE = "ued.probes:frontier", "every length"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return a folder of runs: three of two methods, one in a folder of its own."""
    folder = tmp_path_factory.mktemp("runs")
    for game, method, seed, out in (
        (GAME, "dr", 0, "dr-0"),
        (GAME, "dr", 1, "dr-1"),
        (GAME, "plr", 0, "sub/plr-0"),
    ):
        words = ["train", game, "--method", method, "--seed", str(seed), "--out", str(folder / out), *SMALL]
        assert main(words) == 0
    return folder


def test_a_folder_stands_for_all_its_runs(runs, capsys):
    assert main(["evaluate", str(runs), *BRIEF, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["results"]
    assert {(row["method"], row["seed"]) for row in rows} == {("dr", 0), ("dr", 1), ("plr", 0)}
    report = regista.evaluate(runs, episodes=2)
    assert report.methods == ["dr", "plr", "random"] and report.several == ["dr"]


def test_runs_without_a_checkpoint_are_left_out(runs, tmp_path, capsys):
    folder = tmp_path / "some"
    shutil.copytree(runs, folder)
    (folder / "dr-1" / "checkpoint.pt").unlink()
    assert main(["evaluate", str(folder), *BRIEF, "--json"]) == 0
    said = capsys.readouterr()
    assert "dr-1 has no checkpoint yet; it is skipped" in said.err
    assert {row["seed"] for row in json.loads(said.out)["results"]} == {0}
    for run in ("dr-0", "sub/plr-0"):
        (folder / run / "checkpoint.pt").unlink()
    assert main(["evaluate", str(folder), *BRIEF]) == 1
    assert "none of the 3 runs in" in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert main(["evaluate", str(tmp_path / "empty")]) == 1
    assert "it has no config.json, and holds no run folders" in capsys.readouterr().err


def test_a_run_without_a_checkpoint_restarts_from_zero_with_any_budget(runs, tmp_path, capsys):
    run = tmp_path / "run"
    shutil.copytree(runs / "dr-0", run)
    (run / "checkpoint.pt").unlink()
    assert main(["train", "--resume", str(run), "--total-env-steps", "256"]) == 0
    assert "restarts from zero" in capsys.readouterr().err
    assert RunFolder.open(run).env_steps() == RunFolder.open(run).config.total_env_steps == 256


@pytest.mark.sample(1)
@pytest.mark.parametrize("before", ["Another processor", "This one; another one", None])
def test_a_run_records_each_kind_of_processor_that_trains_it(runs, tmp_path, capsys, before):
    run, here = tmp_path / "run", provenance.hardware()["processor"]
    shutil.copytree(runs / "dr-0", run)
    settings = json.loads((run / "config.json").read_text())
    assert settings["about"]["machine"]["processor"] == here
    settings["about"]["machine"] = {"processor": before} if before else "unknown"
    (run / "config.json").write_text(json.dumps(settings))
    words = ["train", "--resume", str(run), "--total-env-steps"]
    assert main([*words, "1024"]) == main([*words, "1536"]) == 0
    told = f"{run} was trained on {before}; on {here} the last bits of numbers may differ"
    assert capsys.readouterr().err.count(told) == (1 if before else 0)
    assert provenance.processor_of(RunFolder.open(run).about) == (f"{before}; {here}" if before else "")


def test_runs_of_other_settings_and_games_are_told_apart(runs, tmp_path, capsys):
    folder = tmp_path / "mixed"
    shutil.copytree(runs, folder)
    words = ["train", GAME, "--method", "dr", "--learning-rate", "1e-4", "--out", str(folder / "slow"), *SMALL]
    assert main(words) == 0
    assert len(regista.load_comparison(folder).runs) == 4
    assert "share the row 'dr', but differ in ppo.learning_rate; load them separately" in capsys.readouterr().err
    (tmp_path / "dark.py").write_text(TASK)
    other = ["train", f"{tmp_path / 'dark.py'}:caves", "--method", "dr", "--out", str(folder / "other"), *SMALL]
    assert main(other) == 0
    capsys.readouterr()
    assert main(["evaluate", str(folder), *BRIEF]) == 0
    said = capsys.readouterr()
    assert "share the row 'dr', but differ in ppo.learning_rate" in said.err
    assert [line for line in said.out.splitlines() if line in ("probes-frontier", "dark-caves")] == [
        "probes-frontier",
        "dark-caves",
    ]
    assert main(["evaluate", str(folder), *BRIEF, "--csv", str(tmp_path / "x.csv")]) == 1
    assert "evaluate them separately" in capsys.readouterr().err
    with pytest.raises(CommandError, match=r"of different minigames: .*; load them separately"):
        regista.load_comparison(folder)


def test_a_run_that_is_named_twice_keeps_its_first_position(runs):
    """The first method is the reference: `evaluate runs/plr-0 runs` compares with PLR."""
    found = open_runs([runs / "sub" / "plr-0", runs, runs / "dr-1"])
    assert [run.path.name for run in found] == ["plr-0", "dr-0", "dr-1"]


def test_a_run_counts_once_however_often_it_is_named(runs, tmp_path, capsys):
    (tmp_path / "link").symlink_to(runs / "dr-0")
    named = [str(runs / "dr-0"), str(runs), str(runs / "sub" / ".." / "dr-0"), str(tmp_path / "link")]
    assert main(["evaluate", *named, *BRIEF, "--json"]) == 0
    said = capsys.readouterr()
    found = sorted((row["method"], row["seed"]) for row in json.loads(said.out)["results"] if row["scene"] == SCENE)
    assert found == [("dr", 0), ("dr", 1), ("plr", 0)] and "copy" not in said.err


def test_copies_of_a_run_are_warned_of(runs, tmp_path, capsys):
    shutil.copytree(runs / "dr-0", tmp_path / "again")
    assert main(["evaluate", str(runs / "dr-0"), str(tmp_path / "again"), *BRIEF]) == 0
    assert f"{tmp_path / 'again'} is a copy of {runs / 'dr-0'}, so they are one run" in capsys.readouterr().err


def run_of(**env):
    config = TrainConfig("1v1Restricted", env=FootballConfig(**env))
    return SimpleNamespace(path=f"runs/{len(env)}", config=config)


def test_runs_of_other_environments_are_evaluated_separately():
    check_one_game([run_of(), run_of(rewards="scoring,checkpoints"), run_of(grf_workers=2)])  # goals are scored anyway
    for env in ({"engine_spread": 0.9}, {"representation": "simple115"}, {"control": "closest2"}):
        (name, value), *_ = env.items()
        told = rf"runs/0 has {name} = .*, runs/1 has '?{value}.*evaluate them separately"
        with pytest.raises(CommandError, match=told):
            check_one_game([run_of(), run_of(**env)])


def test_a_variant_with_the_name_of_a_baseline_has_a_row_of_its_own(tmp_path, trained_here):
    words = ["compare", GAME, "--methods", "dr", "--variants", "random: --method plr", "--seeds", "1", *SMALL[:-1]]
    assert main([*words, "--no-record", "--episodes", "2", "--levels", "0", "--out", str(tmp_path / "c")]) == 0
    rows = read_rows(tmp_path / "c" / "results.csv")
    trained = {row["method"]: int(row["env_steps"]) for row in rows}
    assert trained["random"] > 0 and trained["random (baseline)"] == 0 and {*trained} >= {"dr", "random"}
    colors = regista.load_comparison(tmp_path / "c").colors()
    assert colors["random (baseline)"] == BASELINES["random"][1] != colors["random"] and {*trained} <= {*colors}


def test_rounds_of_a_timed_evaluation_play_all_levels_of_a_test(runs, monkeypatch):
    run = RunFolder.open(runs / "dr-0")
    scenes, played = EvalScenes(run.config, build.find_game(GAME), 8), []

    class Kept:
        def __init__(self, scene, episodes, seed, levels=None):
            played.extend([] if levels is None else levels["theta"].tolist())

        def play(self, policy, on_end=None):
            return None

    monkeypatch.setattr("ued.evaluation.Schedule", Kept)
    for round in range(2):
        scenes.play(None, [SCENE], round)
    assert len(scenes.theta[SCENE]) == 15 and len({tuple(theta) for theta in played[:15]}) == 15
