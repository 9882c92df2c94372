"""The stored rows of studies: damaged ones, those of another version of the simulator, and their columns."""

import re

import pytest

from lab.studies import rows, tables
from lab.studies.__main__ import main
from regista.experiments.run.errors import CommandError
from regista.experiments.run.report import save_rows
from regista.experiments.run.table import read_rows
from tests.floors import ROOT

UNNUMBERED = "an unnumbered simulator, from before version 1"


def test_the_page_of_the_lab_names_every_column():
    page = (ROOT / "lab" / "README.md").read_text()
    described = re.findall(r"^\| `([^`]+)` \|", page.partition("| column |")[2], re.M)
    assert described == [*rows.Row._fields, *rows.Point._fields]


def test_rows_of_a_study_that_are_none(tmp_path):
    for text in ("game,agent\n1v1,ppo\n", "color\nblue\n"):
        (tmp_path / "rows.csv").write_text(text)
        with pytest.raises(CommandError, match="is damaged"):
            rows.load(tmp_path / "rows.csv")


@pytest.mark.parametrize(
    ("column", "value"), [("episodes", 0), ("seconds", "nan"), ("scored", 401), ("seed", "1" * 30)]
)
def test_rows_of_a_study_that_nobody_measured(tmp_path, column, value):
    row = rows.Row("1v1", "ppo", "closest1", "train", 1, 100, 400, 0.5, 0.1, 3, 0, 20.0, 1.5, "abc", "1")
    path = tmp_path / "rows.csv"
    assert rows.add(path, [row]) == rows.load(path) == [row]
    save_rows([row._asdict() | {column: value}], rows.Row._fields, path)
    with pytest.raises(CommandError, match="is damaged"):
        rows.load(path)


def row(simulator):
    return rows.Row("defense/2vs2", "ppo", "closest1", "train", 0, 100, 50, 0.1, 0.5, 20, 10, 30.0, 1.0, "a", simulator)


def without_version(path):
    """Remove the simulator version from the rows of a file."""
    kept = [{name: text for name, text in one.items() if name != "simulator"} for one in read_rows(path)]
    save_rows(kept, [*kept[0]], path)


@pytest.mark.parametrize(("study", "file"), [("curricula", "curricula"), ("single", "fast")])
def test_unnumbered_rows_are_neither_published_nor_added_to(tmp_path, capsys, study, file):
    table = tmp_path / "results" / f"{file}.csv"
    table.parent.mkdir()
    rows.add(table, [row("1")])
    without_version(table)
    before = table.read_text()
    assert main([study, "--out", str(tmp_path)]) == 1
    said = capsys.readouterr().err
    told = f"rows of {table} were measured on {UNNUMBERED}; on version 1 they can be neither published nor added to"
    assert told in said and "move the file away" in said
    assert table.read_text() == before and sorted(path.name for path in tmp_path.rglob("*")) == [table.name, "results"]


def test_a_file_without_versions_is_of_an_unnumbered_simulator(tmp_path):
    rows.add(tmp_path / "fast.csv", [row("1")])
    assert rows.load(tmp_path / "fast.csv") == [row("1")]
    without_version(tmp_path / "fast.csv")
    assert rows.load(tmp_path / "fast.csv") == [row("0")]
    with pytest.raises(CommandError, match=f"fast.csv were measured on {UNNUMBERED}; on version 1 they can be neither"):
        tables.publish(tmp_path, "fast")
    rows.add(tmp_path / "rows.csv", [row("none")])
    rows.check_present(tmp_path / "rows.csv", rows.load(tmp_path / "rows.csv"))
    assert rows.played_on([row("1"), row("0"), row("none")]) == (
        f"simulator version 1 and {UNNUMBERED} and no simulator of ours"
    )
    with pytest.raises(CommandError, match="damaged: simulator is 'one'"):
        rows.add(tmp_path / "rows.csv", [row("one")]) and rows.load(tmp_path / "rows.csv")
