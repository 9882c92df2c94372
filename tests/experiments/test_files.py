"""docs/files.md names the columns of every table, and the scores of levels follow from their rows."""

import json
import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from regista.experiments.__main__ import main
from regista.experiments.imitation.demonstrations import Demonstrations
from regista.experiments.run import solved
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.report import Entry, Report
from regista.experiments.run.results import LevelResult
from regista.experiments.run.table import read_header

ROOT = Path(__file__).parents[2]
TASK = """
import ued
from ued.probes import Frontier

def make(num_envs):
    return Frontier(num_envs, longest=4)
"""
SHORT = ["--num-envs", "8", "--num-steps", "32", "--hidden-size", "8", "--eval-every", "0", "--no-record"]
SHORT += ["--total-env-steps", "3_000"]
STUDENTS = ("protagonist", "antagonist", "student")


def documented():
    """Return the columns of each table in docs/files.md, by heading."""
    parts = re.split(r"^### (.+)$", (ROOT / "docs" / "files.md").read_text(), flags=re.M)
    tables = [text[text.index("| column") :].partition("\n\n")[0] for text in parts[2::2]]  # the first below each
    return {name: re.findall(r"^\| `([^`]+)` \|", table, re.M) for name, table in zip(parts[1::2], tables, strict=True)}


def general(columns):
    """Return columns of a run with its students, columns of θ and scenes by their placeholders, once each, in order."""
    names = [re.sub(rf"(^|/)({'|'.join(STUDENTS)})(/|$)", r"\1NAME\3", column) for column in columns]
    names = [re.sub(r"^theta/.+", "theta/COLUMN", name) for name in names]
    return list(
        dict.fromkeys(re.sub(r"^(eval|eval_low|eval_high|eval_success)/.+", r"\1/SCENE", name) for name in names)
    )


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """Run folders by method."""
    folder, runs = tmp_path_factory.mktemp("runs"), {}
    (folder / "frontier_task.py").write_text(TASK)
    more = {
        "paired": [],
        "plr": ["--plr.buffer.capacity", "20"],
        "accel": ["--accel.buffer.capacity", "20"],
        "cenie": ["--cenie.buffer.capacity", "20"],
        "ncc": ["--ncc.capacity", "20", "--ncc.score", "mna", "--ncc.episodes-per-level", "2"],
        "sfl": ["--sfl.chosen", "4", "--sfl.candidates", "12", "--sfl.choose-every", "3"],
    }
    for method, settings in more.items():
        command = ["train", f"{folder}/frontier_task.py:make", "--method", method, *SHORT, *settings]
        assert main([*command, "--out", str(folder / method)]) == 0
        runs[method] = RunFolder.open(folder / method)
    return runs


@pytest.mark.slow
def test_the_tables_of_a_run_have_the_columns_of_the_page(trained):
    pages, found = documented(), {"metrics.csv": set(), "levels.csv": set()}
    for run in trained.values():
        for table in (run.metrics, run.levels):
            columns = general(table.columns)
            assert set(columns) <= set(pages[table.path.name]), run.path
            found[table.path.name] |= set(columns)
        levels = general(run.levels.columns)
        assert levels == [name for name in pages["levels.csv"] if name in levels]  # in that order
    assert found["levels.csv"] == set(pages["levels.csv"]) - {"program"}  # of a mixture


def test_other_tables_have_the_columns_of_the_page(tmp_path):
    pages = documented()
    assert pages["table.csv"] == [*Entry._fields, "simulator"]
    assert pages["levels.csv of a comparison"] == [*(item.name for item in fields(LevelResult)), "simulator"]
    assert pages["list --solved --csv"] == [item.name for item in fields(solved.Row)]
    Report([]).save_csv(tmp_path / "results.csv")
    assert pages["results.csv"] == read_header(tmp_path / "results.csv")
    demonstrations = Demonstrations.__new__(Demonstrations)
    demonstrations.summaries = list
    assert general(demonstrations._table(["x"], 0).strip().split(",")) == pages["episodes.csv"]


@pytest.mark.slow
def test_config_json_says_where_a_run_comes_from(trained):
    run = trained["plr"]
    about = json.loads((run.path / "config.json").read_text())["about"]
    assert set(about) == {"id", "began", "command", "commit", "versions", "machine"}
    assert about["versions"]["numpy"] == np.__version__ and about["machine"]["cores"] >= 1
    assert len({each.recording_id for each in trained.values()}) == len(trained)
    again = RunFolder.open(run.path)
    again.extend(again.config.__class__(**{**vars(again.config), "total_env_steps": 13_000}))
    with again.locked():
        again.save_config()
    assert RunFolder.open(run.path).about == about


# ---------------------------------------------------------------- what follows from a row


def levels_of(run):
    levels = read_levels(run.path)
    return levels, levels["source"]


@pytest.mark.slow
def test_paireds_regret_follows_from_the_row(trained):
    levels, source = levels_of(trained["paired"])
    best = np.maximum(levels["best/protagonist"], levels["best/antagonist"])
    mean = (levels["return/protagonist"] + levels["return/antagonist"]) / 2
    assert len(mean) > 50 and np.allclose(levels["score"], best - mean, atol=3e-5)
    assert set(source) == {"random", "proposed"} and 0.1 < np.mean(source == "random") < 0.4
    assert len(set(levels["id"])) == len(levels["id"])


@pytest.mark.slow
@pytest.mark.parametrize("method", ["plr", "accel"])
def test_max_mc_follows_from_the_row(trained, method):
    levels, source = levels_of(trained[method])
    assert len(source) > 50 and np.allclose(levels["score"], levels["best_ever"] - levels["value"], atol=3e-5)
    assert (levels["best_ever"] >= levels["best/student"]).all()
    replayed, known = levels["id"][source == "replayed"], set()
    for update in np.unique(levels["update"]):  # one that is replayed was played before
        rows = levels["update"] == update
        known |= set(levels["id"][rows & (source != "replayed")])
        assert set(levels["id"][rows & (source == "replayed")]) <= known
    assert len(replayed) > 10


@pytest.mark.slow
def test_mna_follows_from_the_row(trained):
    levels, source = levels_of(trained["ncc"])
    score, solved = levels["score"], levels["success/student"] > 0
    assert solved.sum() > 10 and np.allclose(score[solved], levels["negative_advantage"][solved], atol=3e-5)
    assert ((score == 0) | np.isclose(score, levels["negative_advantage"], atol=3e-5)).all() and (score == 0).any()
    known = set(levels["id"][source == "random"])
    assert set(levels["id"][source == "replayed"]) <= known and (source == "replayed").sum() > 10


@pytest.mark.slow
def test_a_child_lies_beside_its_parent(trained):
    levels, source = levels_of(trained["accel"])
    theta = np.stack([column for name, column in levels.items() if name.startswith("theta/")], 1)
    place = {int(level): row for level, row in zip(levels["id"], theta, strict=True)}
    edited = source == "edited"
    moved = [
        abs(row - place[int(parent)]).max() for row, parent in zip(theta[edited], levels["parent"][edited], strict=True)
    ]
    assert len(moved) > 10 and max(moved) <= 0.6 + 1e-4  # three edits of 0.2 at most
    assert np.isnan(levels["parent"][~edited]).all()


@pytest.mark.slow
def test_sfls_learnability_follows_from_the_row(trained):
    levels, source = levels_of(trained["sfl"])
    judged = ~np.isnan(levels["score"])
    p, n = levels["success/student"][judged], levels["episodes"][judged]
    assert judged.sum() > 10 and (n == 4).all()
    assert np.allclose(levels["score"][judged], p * (1 - p) * n / (n - 1) + 0.001 * p, atol=3e-5)
    chosen = levels["id"][source == "replayed"]
    assert len(chosen) and np.isin(chosen, levels["id"][judged]).all()
