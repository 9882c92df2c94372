"""`python -m lab.benchmarks --suite language` measures programs with behaviors, too."""

import json
from pathlib import Path

import pytest

from lab.benchmarks.__main__ import main
from lab.benchmarks.behaviors import CASES, PROGRAMS

pytestmark = pytest.mark.slow

THESIS = Path(__file__).parents[2] / "tests" / "programs" / "figure_2_1.scenic"


def test_every_program_is_installed_and_the_figure_is_the_thesiss():
    assert set(CASES) <= {path.stem for path in PROGRAMS.glob("*.scenic")}
    assert (PROGRAMS / "figure_2_1.scenic").read_text() == THESIS.read_text()


@pytest.mark.long
def test_the_suite_measures_them(capsys, monkeypatch):
    monkeypatch.setattr("lab.benchmarks.language.CASES", {})
    monkeypatch.setattr("lab.benchmarks.behaviors.NUM_ENVS", 4)
    assert main(["--suite", "language", "--seconds", "0.001", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["results"]["behaviors"]
    assert [row["what"] for row in rows] == list(CASES.values())
    assert all(row["steps_per_second"] > 0 and "compiled in" in row["note"] for row in rows)
    assert main(["--suite", "language", "--seconds", "0.001"]) == 0
    assert "Scenic alone, without a simulator" in capsys.readouterr().out
