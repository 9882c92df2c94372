"""`regista study`: what it trains, how it goes on, what it leaves behind."""

import csv

import pytest

from experiments.__main__ import main
from experiments.commands import study
from experiments.commands.train import train
from experiments.run.folder import RunFolder
from tests.envs.grf.fixtures import fake_python

GAMES = ["academy/pass_and_shoot_with_keeper", "1v1Restricted"]
SHORT = ["--total-env-steps", "32", "--num-envs", "4", "--num-steps", "8", "--episodes", "3", "--grf-episodes", "2"]
SPREAD = ["--engine-spread", "0.15"]  # of our simulator alone


@pytest.fixture
def words(monkeypatch, tmp_path):
    """Return what is typed; runs train in this process, and a stand-in plays the real engine's part."""

    def train_all(runs, processes, stop):
        for run in runs:
            train(RunFolder.open(run.path), stop)

    monkeypatch.setattr(study, "train_all", train_all)
    monkeypatch.setenv("REGISTA_GRF_PYTHON", str(fake_python(tmp_path)))
    few = ["--seeds", "1", "--representations", "features"]
    return ["study", "transfer", "--games", *GAMES, *few, *SHORT, *SPREAD, "--out", str(tmp_path / "out")]


def test_a_study_trains_plays_and_tabulates_and_keeps_what_is_there(words, capsys, tmp_path):
    assert main(words) == 0
    shown = capsys.readouterr()
    assert "2 runs, 0 finished" in shown.out and "sampled: 0 of 2 ratios" in shown.out
    folder = tmp_path / "out"
    first = RunFolder.open(folder / "academy_pass_and_shoot_with_keeper-features-0").config
    second = RunFolder.open(folder / "1v1Restricted-features-0").config
    assert (first.env.control, second.env.control) == ("active", "closest1")
    assert first.env.rewards == "scoring,checkpoints" and first.method == "dr" and not first.record
    with open(folder / "transfer.csv") as file:
        assert [(row["game"], row["engine"]) for row in csv.DictReader(file)] == [
            (game, engine) for game in GAMES for engine in ("ours", "grf")
        ]
    assert (folder / "transfer.md").read_text().count("| dr | sampled | 1 |") == 2
    assert main(words) == 0
    again = capsys.readouterr()
    assert "at a time" not in again.out and again.err.count("kept") == 2


def test_games_have_budgets_of_their_own_unless_one_is_given(tmp_path):
    config = study.StudyConfig(
        games=("academy/run_to_score", "1v1Free"), representations=("smm",), out=tmp_path, seeds=2
    )
    runs = study.prepare(config, {})
    assert [run.config.total_env_steps for run in runs] == [500_000, 1_000_000] * 2
    assert [run.config.seed for run in runs] == [0, 0, 1, 1]
    assert {run.config.env.representation for run in runs} == {"smm"}
    longer = study.prepare(config, {"total_env_steps": 2_000_000})
    assert {RunFolder.open(run.path).config.total_env_steps for run in longer} == {2_000_000}


def test_a_study_takes_settings_of_training_but_not_one_representation(words, capsys, tmp_path):
    assert main([*words, "--representation", "smm"]) == 2
    assert "a study takes --representations" in capsys.readouterr().err
    assert main([*words, "--gamma", "0.5"]) == 0
    assert RunFolder.open(tmp_path / "out" / "1v1Restricted-features-0").config.ppo.gamma == 0.5
    assert main(words) == 1  # other settings than those that are there
    assert "was trained with ppo.gamma = 0.5" in capsys.readouterr().err
