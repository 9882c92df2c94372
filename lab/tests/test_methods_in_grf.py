"""`python -m lab.methods_in_grf`: its runs, its engines, and its table."""

from functools import partial

import pytest

from lab import methods_in_grf
from lab.methods_in_grf import DUEL, METHODS, RARE_GAME, Played, Trained, duel_runs, main, rare_runs, rates, table
from lab.studies.rows import add, load
from lab.studies.runs import StudyRuns, training
from regista.experiments.commands import train
from regista.experiments.run.errors import CommandError


def row(engine, agent, seed, scored, order="first", scene="line"):
    return Played(engine, RARE_GAME, agent, order, seed, scene, 4_000_000, 100, scored, "1")


def test_it_plays_each_method_with_all_seeds_and_orders(tmp_path):
    rare = [run[:4] for run in rare_runs(tmp_path)]
    assert [run for run in rare if run[3] == 40][:2] == [
        (RARE_GAME, "dr", "first", 40),
        (RARE_GAME, METHODS[RARE_GAME][1], "even", 40),
    ]
    assert len(rare) == 10 * (1 + 1 + 3 + 3) and {run[1] for run in rare} == set(METHODS[RARE_GAME])
    duels = [run[:4] for run in duel_runs(tmp_path)]
    assert duels[:3] == [(DUEL, name, "", 0) for name in METHODS[DUEL]] and len(duels) == 3 * 10


def test_orders_and_scenes_of_a_seed_are_one_value():
    orders = (("first", 60), ("last", 80))
    rows = [row("GRF", "plr", seed, scored, order) for seed in (40, 41) for order, scored in orders]
    rows += [row("GRF", "plr", seed, 100, order, "out") for seed in (40, 41) for order in ("first", "last")]
    assert rates(rows) == pytest.approx([0.85, 0.85])


def test_differences_are_within_an_engine_and_marked():
    rows = [row(engine, "dr", seed, 20 + seed % 10) for engine in ("ours", "GRF") for seed in range(40, 45)]
    rows += [row("ours", "plr", seed, 80 + seed % 10) for seed in range(40, 45)]
    rows += [row("GRF", "plr", seed, 22 + seed % 10) for seed in range(40, 45)]
    lines = table(rows).splitlines()
    assert lines[0] == "| game | method | runs | our simulator | our simulator: minus dr | GRF | GRF: minus dr |"
    dr, plr = (next(line for line in lines if f"| {name} |" in line) for name in ("dr", "plr"))
    assert dr.startswith(f"| {RARE_GAME} | dr | 5 | 22% [") and dr.endswith("|  |")
    assert "| +60 [+57, +63] * |" in plr and plr.endswith("| +2 [-1, +5] |")
    assert "Holm's correction at 5% over the 2 differences" in table(rows)


def test_a_run_that_is_not_trained_is_named(tmp_path):
    with pytest.raises(CommandError, match=r"is not trained; first: python -m lab\.paired_football"):
        main(["--runs", str(tmp_path), "--csv", str(tmp_path / "rows.csv")])


@pytest.mark.slow
def test_runs_are_played_once(tmp_path, monkeypatch, capsys):
    run = StudyRuns(tmp_path / "runs", training(), {"total_env_steps": 1024, "num_envs": 8}).open(
        RARE_GAME, 40, {}, "dr-"
    )
    assert train.main(run.argv[1:]) == 0
    one = Trained(RARE_GAME, "dr", "first", 40, partial(lambda: run))
    monkeypatch.setattr(methods_in_grf, "RUNS", {RARE_GAME: lambda folder: [one]})
    monkeypatch.setattr(methods_in_grf, "ENGINES", {"ours": "regista"})
    monkeypatch.setattr(methods_in_grf, "EPISODES", {"ours": 10})
    path = tmp_path / "rows.csv"
    assert main(["--csv", str(path)]) == 0
    rows = load(path, Played)
    assert [(row.scene, row.episodes, row.simulator) for row in rows] == [("line", 10, "1"), ("out", 10, "1")]
    monkeypatch.setattr(methods_in_grf, "measure", None)  # nothing is played again
    assert main(["--csv", str(path)]) == 0 and f"| {RARE_GAME} | dr |" in capsys.readouterr().out
    add(path, [rows[0]._replace(simulator="0")], Played)
    with pytest.raises(CommandError, match="can be neither published nor added to"):
        main(["--csv", str(path), "--table"])
