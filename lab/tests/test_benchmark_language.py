"""`python -m lab.benchmarks --suite language`: every program of the table exists and is measured."""

import json

import pytest

from lab.benchmarks.__main__ import main
from lab.benchmarks.language import CASES, PROGRAMS

pytestmark = pytest.mark.slow


def test_every_program_of_the_table_is_installed():
    assert set(CASES) <= {path.stem for path in PROGRAMS.glob("*.scenic")}


@pytest.mark.long
def test_the_table_and_the_json_hold_the_same_programs(capsys, monkeypatch):
    monkeypatch.setattr("lab.benchmarks.language.LARGE", 64)
    monkeypatch.setattr("lab.benchmarks.language.SMALL", 8)
    assert main(["--suite", "language", "--seconds", "0.001", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["results"]["language"]
    assert [row["program"] for row in rows] == list(CASES)
    for row in rows:
        assert row["scenes_per_second"] > 0 and row["load_ms"] > 0 and 0 < row["valid"] <= 1
    teams = rows[1]
    assert (teams["objects"], teams["draws"]) == (23, 46)


def test_the_table_names_the_original(capsys, monkeypatch):
    monkeypatch.setattr("lab.benchmarks.language.CASES", {"soft": CASES["soft"]})
    assert main(["--suite", "language", "--seconds", "0.001"]) == 0
    table = capsys.readouterr().out
    assert "Scenic 3.1.1: scenes/s" in table and "soft" in table
