"""The family `goals`: where the goals of trained runs come from."""

import json

import pytest

from lab.benchmarks.__main__ import main
from regista.experiments.commands import train

pytestmark = pytest.mark.slow


@pytest.fixture
def run(tmp_path):
    """Return a run that has learned nothing yet."""
    words = ["academy/pass_and_shoot_with_keeper", "--method=dr", "--representation=simple115"]
    short = ["--total-env-steps=64", "--num-envs=4", "--num-steps=8", "--eval-every=0", "--no-record"]
    assert train.main([*words, *short, "--out", str(tmp_path / "short")]) == 0
    return tmp_path / "short"


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
