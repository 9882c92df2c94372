"""The demo's repetitions: the Makefile's command with other seeds, a row for each, and no repetition done twice."""

import csv

import pytest

from lab import demo_repeats
from regista.experiments.run.report import save_rows

FIELDS = ["method", "seed", "scene", "episodes", "mean_return", "goals", "env_steps"]


def test_the_command_is_that_of_the_makefile():
    words = demo_repeats.command()
    assert words[0] == "compare" and "--out" not in words and demo_repeats.seeds(words) >= 5
    assert not set(words) & {"\\", "demo"}


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """Return the commands of the repetitions; DR's rates begin at 50%, PLR's at 70%."""
    given = []
    count = demo_repeats.seeds(demo_repeats.command())

    def compare(words):
        given.append(words)
        first, folder = int(words[words.index("--first-seed") + 1]), words[words.index("--out") + 1]
        rates = {"dr": 50, "plr": 70}
        rows = [
            dict(zip(FIELDS, (name, first + k, scene, 100, 0.5, rate + k, 1000), strict=True))
            for name, rate in rates.items()
            for k in range(count)
            for scene in ("a", "b")
        ]
        rows += [dict(zip(FIELDS, ("random", 0, scene, 100, 0.0, 3, 0), strict=True)) for scene in ("a", "b")]
        save_rows(rows, FIELDS, demo_repeats.Path(folder) / "results.csv")
        return 1 if len(given) == 3 else 0

    for name, value in (("regista", compare), ("ROWS", tmp_path / "demo.csv"), ("REPETITIONS", 3)):
        monkeypatch.setattr(demo_repeats, name, value)
    return given


def test_each_repetition_has_fresh_seeds_and_a_row_and_is_done_once(asked, tmp_path, capsys):
    words = ["--out", str(tmp_path / "runs")]
    for repetition in range(3):
        (tmp_path / "runs" / str(repetition)).mkdir(parents=True)
    assert demo_repeats.main(words) == 1  # the third comparison fails
    assert demo_repeats.main(words) == 0
    firsts = [given[given.index("--first-seed") + 1] for given in asked]
    seeds = [str(2000 + k * demo_repeats.seeds(demo_repeats.command())) for k in range(3)]
    assert firsts == [*seeds, seeds[2]]
    with (tmp_path / "demo.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["repetition"], row["seed"], row["method"]) for row in rows] == [
        (str(k), seed, "plr") for k, seed in enumerate(seeds)
    ]
    assert all(float(row["low"]) < float(row["difference"]) == 20 < float(row["high"]) for row in rows)
    assert "plr: the interval of the difference excludes 0 in 3 of 3 repetitions" in capsys.readouterr().out
