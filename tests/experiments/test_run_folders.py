"""`regista evaluate FOLDER` evaluates all runs in a folder, grouped by method."""

import json
import shutil

import pytest

import regista
from regista.experiments.__main__ import main
from tests.experiments.test_play_level import TASK

SMALL = ["--total-env-steps", "512", "--num-envs", "4", "--num-steps", "64", "--eval-every", "0", "--no-record"]
BRIEF = ["--episodes", "2", "--levels", "0", "--no-baselines"]
GAME = "ued.probes:frontier"


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


@pytest.mark.slow
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


def test_runs_of_other_settings_and_games_are_told_apart(runs, tmp_path, capsys):
    folder = tmp_path / "mixed"
    shutil.copytree(runs, folder)
    words = ["train", GAME, "--method", "dr", "--learning-rate", "1e-4", "--out", str(folder / "slow"), *SMALL]
    assert main(words) == 0
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
