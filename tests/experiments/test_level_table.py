"""The table of levels: the same numbers as CSV and as Parquet, complete after a kill, readable by other programs."""

import numpy as np
import pytest

from regista.experiments.run.errors import CommandError
from regista.experiments.run.level_table import CsvLevels, ParquetLevels, open_levels, read_levels
from regista.experiments.run.table import read_header
from ued import read_level
from ued.core import columns as disk

UPDATES = 12


def rows(update, count=40, replayed=False):
    """Return the levels of an update, by column; the ids of replayed ones are not the numbers of their visits."""
    rng, first = np.random.default_rng(update), (update - 1) * count
    returns = rng.integers(0, 3, count) / 3
    parent = np.where(rng.random(count) < 0.3, float(first), np.nan) if replayed else np.full(count, np.nan)
    return {
        "update": np.full(count, update),
        "id": np.arange(first, first + count) - replayed * (first > 0),
        "visit": np.arange(first, first + count),
        "source": np.array(["random", "replayed"])[rng.integers(0, 2, count)],
        "parent": parent,
        "seed": rng.integers(0, 2**31, count, np.uint64),
        "episodes": np.full(count, 2 if replayed else 1),
        "theta/a, b": rng.uniform(-1, 1, count),
        "theta/ego.x": rng.uniform(-1, 1, count),
        "return/student": returns,
        "best/student": returns + replayed * rng.integers(0, 2, count),
        "score": np.where(returns > 0, rng.normal(size=count), np.nan),
    }


def written(folder, form, updates=range(1, UPDATES + 1), replayed_from=6, flush_every=5):
    """Return the table with the levels of these updates."""
    folder.mkdir(exist_ok=True)
    table = open_levels(folder, form)
    for update in updates:
        table.append_levels(rows(update, replayed=update >= replayed_from))
        if update % flush_every == 0:
            table.flush()
    table.flush()
    return table


def contents(table):
    """Return the bytes of a table, by file."""
    paths = sorted(table.path.iterdir()) if table.path.is_dir() else [table.path]
    return {path.name: path.read_bytes() for path in paths}


@pytest.fixture
def small_parts(monkeypatch):
    pytest.importorskip("pyarrow")
    monkeypatch.setattr("regista.experiments.run.level_table.PART_ROWS", 100)


def test_both_forms_have_the_same_numbers(tmp_path, small_parts):
    csv, parquet = (read_levels(written(tmp_path / form, form).path.parent) for form in ("csv", "parquet"))
    whole = {name: np.concatenate([rows(k, replayed=k >= 6)[name] for k in range(1, UPDATES + 1)]) for name in rows(1)}
    assert set(csv) == set(parquet) == set(whole)
    for name, values in whole.items():
        np.testing.assert_array_equal(csv[name], parquet[name])
        if values.dtype.kind == "f" and not name.startswith("theta/"):
            assert np.nanmax(np.abs(csv[name] - values)) <= 5e-6
        else:
            np.testing.assert_array_equal(csv[name], values)
    assert len((tmp_path / "csv" / "levels.csv").read_bytes()) > sum(
        path.stat().st_size for path in (tmp_path / "parquet" / "levels.parquet").iterdir()
    )


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_some_rows_of_a_table_are_those_of_the_whole_table(tmp_path, small_parts, form):
    run = written(tmp_path / form, form).path.parent
    whole = read_levels(run)
    for chosen in ([0, 1, 99, 100, 101, 350], [len(whole["id"]) - 1], [250], []):
        found = read_levels(run, "visit", "theta/", "best/", rows=np.array(chosen, np.int64))
        assert set(found) == {"visit", "theta/a, b", "theta/ego.x", "best/student"}
        for name, values in found.items():
            np.testing.assert_array_equal(values, whole[name][np.array(chosen, np.int64)])


def test_levels_csv_leaves_out_what_follows_until_a_row_differs(tmp_path):
    table = written(tmp_path / "run", "csv", range(1, 6))
    narrow = ["update", "id", "source", "seed", "theta/a, b", "theta/ego.x", "return/student", "score"]
    assert read_header(table.path) == narrow
    before = read_levels(tmp_path / "run")
    table.append_levels(rows(6, replayed=True))
    assert read_header(table.path) == list(rows(1))
    after = read_levels(tmp_path / "run")
    for name, values in before.items():
        np.testing.assert_array_equal(after[name][: len(values)], values)
    np.testing.assert_array_equal(after["parent"][len(values) :], rows(6, replayed=True)["parent"])


def test_chosen_columns_include_those_that_are_left_out(tmp_path):
    written(tmp_path / "run", "csv", range(1, 3))
    assert set(read_levels(tmp_path / "run", "visit", "best/", "theta/")) == {
        *("visit", "best/student", "theta/a, b", "theta/ego.x")
    }
    for name in ("visit", "parent", "episodes", "best/student"):
        alone = read_levels(tmp_path / "run", name)
        assert list(alone) == [name]
        np.testing.assert_array_equal(alone[name], read_levels(tmp_path / "run")[name])
    with pytest.raises(KeyError, match="no level 5 at visit 6"):
        read_level(tmp_path / "run", 5, 6)
    assert read_level(tmp_path / "run", 5, 5)["theta"].tolist() == [
        [rows(1)[f"theta/{n}"][5] for n in ("a, b", "ego.x")]
    ]


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_a_table_that_was_cut_back_and_continued_has_the_same_bytes(tmp_path, small_parts, form):
    whole = contents(written(tmp_path / "whole", form))
    for saved in range(UPDATES + 1):
        for ahead in {saved, min(saved + 1, UPDATES), UPDATES}:  # killed with the table this far
            folder = tmp_path / f"{saved}-{ahead}"
            written(folder, form, range(1, ahead + 1), flush_every=1)
            table = open_levels(folder, form)
            table.replace(table.until(saved))
            known = read_levels(folder, "update").get("update", np.zeros(0))
            assert len(known) == 40 * saved and known.max(initial=0) <= saved
            assert contents(written(folder, form, range(saved + 1, UPDATES + 1), flush_every=3)) == whole


@pytest.mark.slow
def test_a_cut_that_is_interrupted_keeps_all_rows_up_to_the_checkpoint(tmp_path, small_parts):
    for count in range(4):
        folder = tmp_path / str(count)
        cuts = written(folder, "parquet").until(4)
        assert len(cuts) == 4
        open_levels(folder, "parquet").replace(cuts[:count])
        assert (read_levels(folder, "update")["update"] <= 4).sum() == 160
        again = open_levels(folder, "parquet")
        again.replace(again.until(4))
        assert read_levels(folder, "update")["update"].tolist() == [k for k in range(1, 5) for _ in range(40)]


def test_a_full_file_is_not_written_again(tmp_path, small_parts):
    table = written(tmp_path / "run", "parquet", range(1, 7))
    times = {path.name: path.stat().st_mtime_ns for path in table.path.iterdir()}
    assert sorted(times) == ["part-00000.parquet", "part-00001.parquet", "part-00002.parquet"]
    written(tmp_path / "run", "parquet", range(7, 9))
    assert all((table.path / name).stat().st_mtime_ns == times[name] for name in sorted(times)[:2])


def test_damage_is_one_sentence_and_changes_nothing(tmp_path, small_parts):
    table = written(tmp_path / "run", "parquet")
    part = sorted(table.path.iterdir())[-1]
    part.write_bytes(part.read_bytes()[:-20])
    before = contents(table)
    for act in (lambda: open_levels(tmp_path / "run", "parquet").until(3), lambda: read_levels(tmp_path / "run")):
        with pytest.raises(CommandError, match=rf"{part.name} is damaged: [^\n]+$"):
            act()
    assert contents(table) == before


def test_a_file_that_is_missing_is_damage(tmp_path, small_parts):
    table = written(tmp_path / "run", "parquet")
    (table.path / "part-00001.parquet").unlink()
    with pytest.raises(CommandError, match=r"levels\.parquet is damaged: part-00001\.parquet is missing"):
        open_levels(tmp_path / "run", "parquet").until(UPDATES)


def test_an_older_table_keeps_its_columns(tmp_path):
    older = {"program": np.full(40, "1v1"), **rows(1)}
    CsvLevels(tmp_path / "levels.csv").append_columns(older)
    CsvLevels(tmp_path / "levels.csv").append_levels({"program": np.full(40, "1v1"), **rows(2)})
    assert read_header(tmp_path / "levels.csv") == list(older)
    assert read_levels(tmp_path, "visit")["visit"].tolist() == list(range(80))


def test_the_visits_of_a_table_that_numbered_none_are_unknown(tmp_path):
    older = {name: values for name, values in rows(1).items() if name != "visit"}
    CsvLevels(tmp_path / "levels.csv").append_columns(older)
    assert read_levels(tmp_path, "visit") == {}
    with pytest.raises(ValueError, match="it has no column visit"):
        read_level(tmp_path, 5)


def test_other_columns_are_refused(tmp_path, small_parts):
    for form in ("csv", "parquet"):
        table = written(tmp_path / form, form, range(1, 3))
        with pytest.raises(CommandError, match=r"has the columns .*theta/ego.x.*, expected .*theta/other"):
            table.append_levels({name.replace("ego.x", "other"): values for name, values in rows(3).items()})


def test_without_pyarrow_the_run_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr("regista.experiments.run.level_table.find_spec", lambda name: None)
    with pytest.raises(CommandError, match=r"needs pyarrow: pip install 'regista\[all\]'"):
        ParquetLevels(tmp_path / "levels.parquet").until(0)


def test_pyarrow_and_numpy_read_the_same_numbers(tmp_path, monkeypatch):
    pytest.importorskip("pyarrow")
    path = written(tmp_path / "run", "csv").path
    with open(path, "a") as file:
        file.write("13,999,0.")  # killed in the middle of a row
    found = []
    for large in (0, 10**9):
        monkeypatch.setattr(disk, "LARGE", large)
        found.append(disk.read_csv(path, words=("source",)))
    assert found[0].keys() == found[1].keys() and len(found[0]["id"]) == 40 * UPDATES
    for name, values in found[0].items():
        assert values.dtype.kind == found[1][name].dtype.kind
        np.testing.assert_array_equal(values, found[1][name])


@pytest.mark.parametrize("large", [0, 10**9])
@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        ("1,2\n", "line 3 is not a row of 3 cells"),
        ("1,2,3,4\n", "line 3 is not a row of 3 cells"),
        ("1,2,x\n", "line 3, column c: 'x' is not a number"),
        ('1,"2,3\n', ""),
        ("\n", "it has an empty line"),
        (b"1,2,\xff\n", ""),
    ],
)
def test_damaged_csv_files_are_refused(tmp_path, monkeypatch, large, spoil, reason):
    pytest.importorskip("pyarrow")
    monkeypatch.setattr(disk, "LARGE", large)
    (tmp_path / "t.csv").write_bytes(b"a,b,c\n1,2,3\n" + (spoil if isinstance(spoil, bytes) else spoil.encode()))
    with pytest.raises(ValueError, match=rf"t\.csv is damaged: {reason}[^\n]*$"):
        disk.read_csv(tmp_path / "t.csv")


def test_pandas_reads_both(tmp_path, small_parts):
    pandas = pytest.importorskip("pandas")
    csv = pandas.read_csv(written(tmp_path / "csv", "csv").path)
    parquet = pandas.read_parquet(written(tmp_path / "parquet", "parquet").path)
    _check(csv, parquet, read_levels(tmp_path / "csv"))


def test_polars_reads_both(tmp_path, small_parts):
    polars = pytest.importorskip("polars")
    csv = polars.read_csv(written(tmp_path / "csv", "csv").path)
    parquet = polars.read_parquet(written(tmp_path / "parquet", "parquet").path)
    _check(csv, parquet, read_levels(tmp_path / "csv"))


def _check(csv, parquet, expected):
    assert list(csv.columns) == list(parquet.columns) == list(expected)
    for name, values in expected.items():
        for table in (csv, parquet):
            found = table[name].to_numpy()
            np.testing.assert_array_equal(found.astype(values.dtype), values)


def test_the_table_of_a_folder_is_the_one_that_it_has(tmp_path, small_parts):
    assert isinstance(open_levels(tmp_path, "csv"), CsvLevels)
    assert read_levels(tmp_path) == {}
    for form in ("csv", "parquet"):
        written(tmp_path / form, form, range(1, 3))
        assert read_level(tmp_path / form, 7)["seed"].tolist() == [rows(1)["seed"][7]]
