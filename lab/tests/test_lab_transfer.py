"""The lab's scripts of transfer: tables come from CSV files alone, pages contain them, and units are done once."""

import importlib
import pickle
from pathlib import Path

import pytest

from lab.grf.experts import experts
from regista.experiments.run.folder import RunFolder
from regista.experiments.transfer.episodes import ENDINGS
from tests.envs.grf.fixtures import fake_python

ROOT = Path(__file__).parents[2]
SEED = 400  # the first of the lab's final tables


@pytest.fixture(scope="module")
def lab():
    """Return the modules of `lab` by name."""
    names = ("transfer_tables", "transfer", "academy_baselines")
    return {name: importlib.import_module(f"lab.{name}") for name in names}


def run_rows(game, representation="features", seed=SEED, ours=80, grf=30, **more):
    """Return the rows of a run: `ours` goals of 200 episodes in our simulator, and `grf` goals of 50 in GRF."""
    ends = dict.fromkeys([f"ended/{word}" for word in ENDINGS[:-1]], 0.0)
    key = {"simulator": "7", "game": game, "representation": representation, "seed": seed, "env_steps": 500_000}
    row = {"mean_return": -0.25, "return_error": 0.01, "median_length": 60.0, **ends, **more}
    return [
        {**key, "engine": "ours", "episodes": 200, "goals": ours, **row, "distance/>30": 0.9, "keeper/<2": 0.3},
        {**key, "engine": "grf", "episodes": 50, "goals": grf, **row, "distance/>30": 0.02, "keeper/<2": 0.3},
    ]


@pytest.fixture
def results(lab, tmp_path):
    """Return a folder with a CSV file of each part."""
    save = lab["transfer"].save
    runs = [
        row
        for seed in range(SEED, SEED + 5)
        for representation, goals in (("simple115", 10), ("features", 19))
        for game in ("academy/run_to_score", "1v1Free")
        for row in run_rows(game, representation, seed, 80, goals)
    ]
    save(runs, tmp_path / "transfer_policies.csv")
    save([row for seed in range(3) for row in run_rows("defense/2vs2", seed=seed)], tmp_path / "transfer_defense.csv")
    save(run_rows("academy/run_to_score", "simple115"), tmp_path / "transfer_converse.csv")
    longer = [run_rows("academy/run_to_score", "simple115", budget=budget) for budget in (50_000_000, 5_000_000)]
    save([row for rows in longer for row in rows], tmp_path / "academy_baselines.csv")
    drawn = {"simulator": "7", "seed": 1, "endings_agree": 0.5, "endings_agree_limit": 0.75}
    steps = [f"{what}_{step}" for what in ("ball", "players") for step in (10, 20, 40)]
    drawn |= {f"{step}{limit}": 1.5 for step in steps for limit in ("", "_limit")}
    save([{**drawn, "scene": f"1:{k}"} for k in range(5)], tmp_path / "transfer_scenes.csv")
    of = {"simulator": "7", "seed": 3, "episodes": 200}
    played = [
        {**of, "program": each.name, "engine": engine, "goals": 10 * (k + 1)}
        for k, each in enumerate(experts())
        for engine in ("ours", "grf")
    ]
    save(played, tmp_path / "transfer_experts.csv")
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("name", ["TRANSFER.md", "BENCHMARK.md"])
def test_the_pages_have_the_tables_that_the_files_make(lab, name):
    text = (ROOT / name).read_text()
    assert "<!-- table:" in text
    assert lab["transfer_tables"].filled(text) == text, "python -m lab.transfer tables"


def test_every_table_has_a_place(lab):
    tables = lab["transfer_tables"]
    places = [place[1] for name in tables.PAGES for place in tables.PLACE.findall((ROOT / name).read_text())]
    assert sorted(places) == sorted([*tables.TABLES, "summary"])


@pytest.mark.long
def test_tables_say_what_is_in_the_files(lab, results):
    tables = lab["transfer_tables"]
    text = "\n".join((ROOT / name).read_text() for name in tables.PAGES)
    made = tables.filled(text, results)
    assert tables.NOTHING not in made and made.count("Simulator 7; `python -m lab.") == len(tables.TABLES)
    assert "`simple115` | 0 of 2; 0 below 50%" in made and "`features` | 2 of 2; 0 below 50%" in made
    assert "both together | 0 of 2; 0 below 50%; lowest ratio 0.73 |" in made  # 0.2 and 0.38 of 0.4
    assert f"seeds {SEED} to {SEED + 4}" in made and "200 episodes of each run in our simulator, 50 in GRF" in made
    assert "**from >30 m**" in made and "| 2: academy/run_to_score, 1v1Free |" in made
    assert "| endings that agree | 50% [50, 50] | 75% [75, 75] |" in made
    assert "over 9 programs: 1.00 [1.00, 1.00]" in made
    assert made.count("| +0.92 ± 0.04 |\n") == 2  # published, beside both budgets
    assert tables.filled(made, results) == made


def test_a_part_without_a_file_names_the_command(lab, tmp_path):
    made = lab["transfer_tables"].filled("a\n<!-- table: scenes -->\nold\n<!-- end -->\n", tmp_path)
    assert "old" not in made and "`python -m lab.transfer scenes` makes this table." in made


def test_few_goals_are_no_exploit(lab):
    tables = lab["transfer_tables"]
    assert tables.exploited(run_rows("1v1Free", grf=30)) == ["**from >30 m**"]
    assert tables.exploited(run_rows("1v1Free", grf=19)) == ["fewer than 20 goals"]
    even = run_rows("1v1Free")
    even[1]["distance/>30"] = 0.2
    assert tables.exploited(even) == []


def test_parts_begin_with_the_first_seed_of_all_games(lab):
    units = list(lab["transfer"].policies())
    assert len(units) == 90 and [unit.key["seed"] for unit in units[:19]] == [SEED] * 18 + [SEED + 1]
    assert units[0].settings["program.param"] == ("jitter=1",) and "program.param" not in units[8].settings
    for part in lab["transfer"].PARTS.values():
        assert pickle.loads(pickle.dumps(list(part()))) == list(part())  # as sent to other processes
    assert {name: len(list(part())) for name, part in lab["transfer"].PARTS.items()} == {
        "policies": 90,
        "defense": 12,
        "scenes": 20,
        "experts": 9,
        "converse": 6,
    }


def test_budgets_of_the_academy_are_runs_of_their_own(lab):
    short, long = (list(lab["academy_baselines"].units(["academy/empty_goal"], 1, steps)) for steps in (5, 50))
    assert lab["transfer"].missing(long, [unit.key for unit in short]) == long


def test_what_has_rows_of_this_simulator_is_not_done_again(lab, tmp_path, monkeypatch):
    transfer, path = lab["transfer"], tmp_path / "rows.csv"
    units = list(transfer.defense())
    rows = [dict(row, simulator="8") for row in run_rows("defense/2vs2")]
    transfer.save(rows, path)
    monkeypatch.setattr(transfer, "simulator_version", lambda: "8")
    left = transfer.missing(units, transfer.load(path))
    assert len(left) == 11 and units[0] not in left
    monkeypatch.setattr(transfer, "simulator_version", lambda: "9")
    assert transfer.load(path) == [] and transfer.missing(units, []) == units


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 8])  # a game of the academy, whose levels are jittered, and another game
def test_a_run_is_trained_once_and_played_in_both_engines(lab, tmp_path, monkeypatch, number):
    monkeypatch.setenv("REGISTA_GRF_PYTHON", str(fake_python(tmp_path)))
    transfer = lab["transfer"]
    unit = list(transfer.policies())[number]
    unit = unit._replace(settings={**unit.settings, "num_envs": 4, "ppo.num_steps": 128})
    options = transfer.Options(tmp_path / "out", tmp_path, 1, 1.0, 0, env_steps=1024, episodes=3)
    rows = transfer.do(unit, options)
    assert [(row["engine"], row["episodes"], row["env_steps"], row["seed"]) for row in rows] == [
        ("ours", 3, 1024, SEED),
        ("grf", 3, 1024, SEED),
    ]
    (folder,) = (path.parent for path in tmp_path.rglob("config.json"))
    config = RunFolder.open(folder).config
    assert config.env.representation == "simple115" and config.env.rewards == "scoring,checkpoints"
    assert (config.program.param, config.env.engine_spread) == ((("jitter=1",) if number == 0 else ()), 0.15)
    monkeypatch.setattr(transfer.train, "main", None)  # the run is already trained
    again = transfer.do(unit, options)
    assert [dict(row, core_seconds=0) for row in again] == [dict(row, core_seconds=0) for row in rows]
