"""Tables that survive a kill."""

import math

import numpy as np
import pytest

from regista.experiments.run.errors import CommandError
from regista.experiments.run.table import Table, read_columns, read_rows


def test_rows_read_back_equal(tmp_path):
    table = Table(tmp_path / "t.csv")
    values = [0.1, 1 / 3, 1e-300, 3.0, -0.0]
    for update, value in enumerate(values, start=1):
        table.append([{"update": update, "value": value, "a, b": 2}])
    columns = read_columns(tmp_path / "t.csv")
    assert columns["value"].tolist() == values
    assert columns["a, b"].tolist() == [2.0] * 5


def test_nan_and_absent_are_empty_cells(tmp_path):
    table = Table(tmp_path / "t.csv")
    table.append([{"update": 1, "x": 1.0, "y": math.nan}, {"update": 2, "x": None}])
    assert (tmp_path / "t.csv").read_text() == "update,x,y\n1,1,\n2,,\n"
    assert np.isnan(read_columns(tmp_path / "t.csv")["y"]).all()


def test_a_new_column_widens_the_table(tmp_path):
    table = Table(tmp_path / "t.csv")
    table.append([{"update": 1, "x": 0.5}])
    table.append([{"update": 2, "x": 0.25, "y": 7}])
    assert (tmp_path / "t.csv").read_text() == "update,x,y\n1,0.5,\n2,0.25,7\n"


def test_resuming_drops_later_rows_and_a_torn_one(tmp_path):
    table = Table(tmp_path / "t.csv")
    table.append([{"update": update, "x": update / 10} for update in range(1, 6)])
    with open(tmp_path / "t.csv", "a") as file:
        file.write("6,0.")  # killed in the middle of a row
    assert len(read_rows(tmp_path / "t.csv")) == 5
    again = Table(tmp_path / "t.csv")
    again.replace(again.until(3))
    again.append([{"update": 4, "x": 0.4}])
    assert read_columns(tmp_path / "t.csv")["update"].tolist() == [1, 2, 3, 4]


def test_a_folder_that_is_gone_is_one_sentence(tmp_path):
    table = Table(tmp_path / "nowhere" / "t.csv")
    with pytest.raises(CommandError, match=r"cannot write .*t\.csv.*: No such file or directory"):
        table.append([{"update": 1}])


def test_the_column_of_an_older_run_has_its_present_name_and_rows_are_added(tmp_path):
    path = tmp_path / "levels.csv"
    path.write_text("update,id,turn\n1,4,7\n")
    table = Table(path)
    table.append_columns({"update": np.array([2]), "id": np.array([5]), "visit": np.array([8])})
    assert [(row["id"], row["visit"]) for row in read_rows(path)] == [("4", "7"), ("5", "8")]
    table.append([{"update": 3, "id": 6, "visit": 9, "more": 1}])
    assert path.read_text().splitlines()[0] == "update,id,visit,more"
