"""Files are there whole or as they were."""

import os
import subprocess
import sys

import pytest

from ued.core.files import is_partial, write_whole


def test_a_refused_write_leaves_the_file_as_it_was_and_nothing_beside(tmp_path, monkeypatch):
    path = tmp_path / "table.csv"
    write_whole(path, "old")

    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match=r"No space left on device: .*table\.csv'$"):
        write_whole(path, b"new")
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["table.csv"]


def test_what_the_killed_have_left_goes_with_the_next_write_and_nothing_else(tmp_path):
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    dead, living = (tmp_path / f".table.csv.{number}.partial" for number in (process.pid, os.getppid()))
    other, foreign = tmp_path / f".other.csv.{process.pid}.partial", tmp_path / ".table.csv.mine.partial"
    for each in (dead, living, other, foreign):
        each.write_text("half")
    assert all(is_partial(name) for name in os.listdir(tmp_path)) and not is_partial("table.csv")
    write_whole(tmp_path / "table.csv", "whole")
    assert not dead.exists() and living.exists() and other.exists() and foreign.exists()
