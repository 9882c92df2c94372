"""Tests of the notebooks: each runs unchanged, with the same kinds of output as it stores. Read next: `notebooks`."""

import re

import pytest

from tests.pages import ROOT

nbformat = pytest.importorskip("nbformat", reason="notebooks need nbformat")
EXAMPLES = ROOT / "examples"
NOTEBOOKS = sorted(path.name for path in EXAMPLES.glob("*.ipynb"))
SHOWS = {
    "own_environment.ipynb": {"stdout", "text/html", "image/png"},
    "football_curriculum.ipynb": {"stdout", "text/html", "image/png", "image/gif"},
}


def stored(name):
    return nbformat.read(EXAMPLES / name, 4)


def test_each_notebook_is_known():
    assert set(NOTEBOOKS) == set(SHOWS)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_outputs_are_stored_without_a_trace_of_a_machine(name):
    from tests.notebooks import kinds

    text = (EXAMPLES / name).read_text()
    assert re.findall(r"(?<![\w.:/])/(?:home|root|tmp|work|usr|opt|Users|var|mnt)/", text) == []
    assert len(text) < 1_000_000
    assert {kind for cell in stored(name).cells for kind in kinds(cell)} == SHOWS[name]
    assert [cell.source for cell in stored(name).cells if cell.cell_type == "code" and not cell.execution_count] == []


@pytest.mark.long
@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_runs(name, tmp_path):
    pytest.importorskip("pandas", reason="notebooks show tables")
    from tests.notebooks import executed, kinds

    made, shown = executed(EXAMPLES / name, tmp_path), stored(name)
    assert [kinds(cell) for cell in made.cells] == [kinds(cell) for cell in shown.cells]
