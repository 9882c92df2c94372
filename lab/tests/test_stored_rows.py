"""All CSV files of the lab: complete rows, the simulator version, seeds of final tables and of tuning."""

import csv
import re
from functools import cache

import pytest

from lab.paired_football import STUDY
from lab.studies.curricula import COMPARISONS
from lab.thesis import plan
from regista.envs.football.version import SIMULATOR_VERSION
from tests.floors import ROOT

LAB = ROOT / "lab"
FILES = sorted(LAB.glob("**/*.csv"))
MEASURED = [path for path in FILES if "data" not in path.parts]  # the others are measurements of GRF
EARLY = {"paired_frontier.csv": range(20, 30)}  # tuning on seeds below 1000


@cache
def rows_of(path):
    with open(path, newline="") as file:
        head, *rows = csv.reader(line for line in file if not line.startswith("#"))
    return head, rows


@cache
def listed():
    """Return the page's entry for each file: (rows, simulator)."""
    page = (LAB / "README.md").read_text()
    found = re.findall(r"^\| \[`([^`]+\.csv)`\]\([^)]+\) \| ([^|]+) \| ([^|]+) \|$", page, re.M)
    return {LAB / name: (kind, played) for name, kind, played in found}


def kind_of(path):
    return listed().get(path, ("tuning" if "tuning" in path.stem else "final", "football"))


def seeds_of(path):
    head, rows = rows_of(path)
    return {int(row[head.index("seed")]) for row in rows} if "seed" in head else set()


@pytest.mark.slow
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(LAB).as_posix())
def test_rows_are_whole(path):
    head, rows = rows_of(path)
    assert len(set(head)) == len(head) and rows
    assert {len(row) for row in rows} == {len(head)}


@pytest.mark.parametrize("path", MEASURED, ids=lambda path: path.stem)
def test_rows_of_football_have_the_version_of_the_simulator(path):
    head, rows = rows_of(path)
    if kind_of(path)[1] == "football":
        assert {row[head.index("simulator")] for row in rows} == {str(SIMULATOR_VERSION)}
    elif "simulator" in head:
        assert {row[head.index("simulator")] for row in rows} == {"none"}


def test_the_page_lists_files_that_exist():
    assert set(listed()) <= set(MEASURED) and len(listed()) > 10
    assert {kind for kind, _ in listed().values()} == {"final", "tuning", "speed", "published by others"}
    assert {played for _, played in listed().values()} == {"football", "no football"}


def test_no_seed_of_a_final_table_is_in_a_tuning_table():
    final = {seed for path in MEASURED if kind_of(path)[0] == "final" for seed in seeds_of(path)}
    tuning = {path.name: seeds_of(path) for path in MEASURED if kind_of(path)[0] == "tuning"}
    assert {0, 19, 400} <= final and tuning
    for name, seeds in tuning.items():
        assert not seeds & final, name
        assert seeds <= set(EARLY[name]) if name in EARLY else min(seeds) >= 1000, name


def test_studies_begin_where_their_tables_belong():
    first = {name: comparison.first_seed for name, comparison in COMPARISONS.items()}
    assert {name for name, seed in first.items() if seed >= 1000} == {"tuning"}
    assert set(plan.SEEDS) == set(range(10))


def test_no_study_will_have_a_seed_of_tuning():
    tuning = {seed for path in MEASURED if kind_of(path)[0] == "tuning" for seed in seeds_of(path)}
    final = {name: comparison for name, comparison in COMPARISONS.items() if comparison.first_seed < 1000}
    planned = {name: range(one.first_seed, one.first_seed + one.most_seeds) for name, one in final.items()}
    planned |= {"rare levels": STUDY.seeds, "thesis": plan.SEEDS}
    assert {name: tuning & set(seeds) for name, seeds in planned.items()} == {name: set() for name in planned}
