"""Files that are no programs, numbers that mean nothing: what a hostile or a clumsy user hands to the language."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from scenic_lite import ScenicError, load

# Each case: a program, and what is printed. The carets say which column is meant.


# ------------------------------------------------------------ files that are no programs


def test_devices_and_pipes_are_not_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.scenic")
    for path in (tmp_path / "pipe.scenic", Path("/dev/zero")):
        with pytest.raises(ScenicError, match="there is no file"):
            load(path)


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "loop.scenic").symlink_to(tmp_path / "loop.scenic")
    (tmp_path / "latin.scenic").write_bytes("ego = LeftCM\n# café\n".encode("latin-1"))
    for name, message in (
        ("loop.scenic", "there is no file"),
        ("x" * 5000 + ".scenic", "there is no file" if sys.version_info >= (3, 14) else "File name too long"),
        ("a\0b.scenic", "there is no file"),
        ("latin.scenic", "latin.scenic is not UTF-8 text: see line 2"),
    ):
        with pytest.raises(ScenicError) as caught:
            load(tmp_path / name)
        assert message in str(caught.value)
        assert len(str(caught.value)) < 300


def test_an_import_leads_nowhere_out_of_the_folder(tmp_path):
    (tmp_path / "secret.scenic").write_text("password = 3\n")
    folder = tmp_path / "program"
    folder.mkdir()
    (folder / "link.scenic").symlink_to(tmp_path / "secret.scenic")
    (folder / "main.scenic").write_text("import link\n")
    with pytest.raises(ScenicError, match=r"link\.scenic is a link that leads out of the program's folder"):
        load(folder / "main.scenic")


def test_what_is_no_text_is_refused():
    with pytest.raises(TypeError, match="load takes the path or the text of a program, not bytes"):
        load(b"ego = 3")  # type: ignore[arg-type]


def test_long_lines_are_shown_around_the_culprit():
    with pytest.raises(ScenicError) as caught:
        load("x = [" + "1, " * 300 + "+]" + " # and so on" * 50)
    _, line, carets = str(caught.value).splitlines()
    assert len(line) <= 4 + 160
    assert line[carets.index("^")] == "]"


def test_messages_command_no_terminal():
    with pytest.raises(ScenicError) as caught:
        load("x = '\x1b[2J\u202e' + nope")
    assert str(caught.value).splitlines()[1] == "    x = '\ufffd[2J\ufffd' + nope"


# ------------------------------------------------------------ numbers and arguments that mean nothing


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("x = Range(0, 1e999)", "1:14: this number is too large"),
        ("x = Range(-1e308, 1e308)", "1:5: Range(-1e+308, 1e+308) has no finite length"),
        ("x = CircularRegion(0 @ 0, -3)", "1:5: the radius of a region must be finite and not negative, not -3"),
        ("x = RectangularRegion(0 @ 0, 0, -1e999, 1)", "1:34: this number is too large"),
        ("ego = new Object with length -1", "1:18: length must be finite and not negative, not -1"),
        ("class A(Object, size=3):\n    pass", "1:22: a class has a base and no other arguments"),
    ],
)
def test_nonsense_is_refused_where_it_is_written(line, message):
    with pytest.raises(ScenicError) as caught:
        load(line)
    assert str(caught.value).startswith("<program>:" + message)


def test_a_region_of_no_extent_is_a_point():
    program = load("ego = new Object in RectangularRegion(3 @ 4, 0, 0, 0)")
    assert program.sample(2, np.random.default_rng(0))[1].positions[:, 0].tolist() == [[3, 4], [3, 4]]


def test_a_requirement_may_index_by_a_random_number():
    program = load("xs = [1, 5, 9]\ni = DiscreteRange(0, 2)\nego = new Object at i @ 0\nrequire xs[i] > 4\n")
    _, scenes = program.sample(200, np.random.default_rng(0))
    assert set(scenes.positions[:, 0, 0]) == {1, 2}


def test_a_soft_requirement_that_never_holds_leaves_the_scenes_without_it():
    program = load("ego = new Object at Range(0, 1) @ 0\nrequire[0.5] ego.x > 2\n")
    with pytest.raises(ScenicError, match=r"only \d+ of 20 scenes found in [\d,]+ draws\n    line 2"):
        program.sample(20, np.random.default_rng(0))
