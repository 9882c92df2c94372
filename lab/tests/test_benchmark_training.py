"""`python -m lab.benchmarks --suite train`: every method has a row, and teams of 2, 4 and 11."""

import json

import pytest

from lab.benchmarks.__main__ import main
from ued.methods import METHODS

pytestmark = pytest.mark.slow


@pytest.mark.long
def test_methods_and_teams_are_measured(monkeypatch, capsys):
    monkeypatch.setattr("lab.benchmarks.timing.WARM_UPDATES", 1)
    monkeypatch.setattr("lab.benchmarks.training.build.METHODS", {"dr": METHODS["dr"]})
    assert main(["--suite", "train", "--seconds", "0.001", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["results"]["training"]
    sizes = (1, 2, 4, 11)
    labels = ["dr, eleven a side, 1 agent"] + [f"dr, eleven a side, {size} agents" for size in sizes[1:]]
    assert [row["what"] for row in rows[-4:]] == labels and rows[0]["what"] == "dr, 1 thread"
    for size, row in zip(sizes, rows[-4:], strict=True):
        assert row["note"].startswith(f"{size * row['steps_per_second']:,.0f} agent-steps/s, ")
