"""The family `goals`: where the goals of trained runs come from."""

import json

import numpy as np
import pytest

from lab.benchmarks.__main__ import main
from lab.grf.measure import goals_table
from regista.experiments.commands import train
from regista.experiments.transfer.goals import Goals

pytestmark = pytest.mark.slow


@pytest.fixture
def run(tmp_path):
    """Return an untrained run."""
    words = ["academy/pass_and_shoot_with_keeper", "--method=dr", "--representation=simple115"]
    short = ["--total-env-steps=64", "--num-envs=4", "--num-steps=8", "--eval-every=0", "--no-record"]
    assert train.main([*words, *short, "--out", str(tmp_path / "short")]) == 0
    return tmp_path / "short"


def test_a_table_has_the_shares_of_distances():
    found = Goals(np.array([11.0, 35.0]), np.array([1.0, 25.0]), np.zeros(2)).summary()
    head, row, none = goals_table([(["a", "sampled", "ours"], found), (["a"] * 3, {"goals": 0})])
    assert dict(zip(head, row, strict=True))["<2 m"] == "50%" and row[4] == "23.0" and set(none[4:]) == {"–"}


def test_the_benchmark_tells_where_goals_of_runs_come_from(run, capsys):
    words = ["--suite", "grf", "--measure", "--family", "goals", "--engine", "regista", "--effort", "0.02"]
    assert main([*words, "--runs", str(run)]) == 0
    head, _, ours, grf = capsys.readouterr().out.rstrip().splitlines()
    assert head.startswith("goals of") and "11 to 20 m" in head and ours.split()[:3] == ["short", "sampled", "ours"]
    assert grf.split()[2] == "grf"
    assert main([*words, "--runs", str(run), "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["results"]["goals"]
    assert found["ours"]["episodes"] == 10 and found["grf"]["episodes"] == 4
    assert main(words) == 2
    assert "goals needs --runs" in capsys.readouterr().err
