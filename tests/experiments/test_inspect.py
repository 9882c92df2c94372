"""`regista inspect` on programs of football and of anything else: pictures, recordings, and what it refuses."""

import numpy as np
import pytest

from regista.experiments.__main__ import main
from regista.experiments.pictures.scene_view import corners, view_of
from regista.experiments.run.programs import read_params
from scenic_lite import load

pytestmark = pytest.mark.drawn

STREET = """
street = PolygonalRegion([(0, 0), (40, 0), (40, 10), (10, 10), (10, 40), (0, 40)])
workspace = Workspace(street)
class Car:
    width: 2
    length: 4
    requireVisible: False
ego = Car in street, facing Range(0, 360) deg
other = Car in street, with width 1
require (distance from ego to other) > 5
"""


@pytest.fixture
def street(tmp_path):
    path = tmp_path / "street.scenic"
    path.write_text(STREET)
    return path


def test_a_program_that_is_no_football_is_shown(street, capsys):
    assert main(["inspect", str(street)]) == 0
    text = capsys.readouterr().out
    for piece in ("D = 5 free parameters", "ego.heading", "other.x", "Car", "other leaves the workspace", "> 5"):
        assert piece in text


def test_parameters_scenario_and_model_are_those_of_the_command_line(tmp_path, capsys):
    path = tmp_path / "roads.scenic"
    (tmp_path / "town.scenic").write_text("class Car:\n    width: 7\n")
    path.write_text("""# scenic: 3
param lanes = 2
scenario Quiet():
    setup:
        ego = new Object at (globalParameters.lanes, 0)
scenario Busy():
    setup:
        ego = new Object at (Range(0, 1), globalParameters.lanes)
        other = new Object at (10, 0)
""")
    assert main(["inspect", str(path), "--scenario", "Busy", "-p", "lanes=30.5", "--show", "scenes", "--n", "1"]) == 0
    text = capsys.readouterr().out
    assert "other" in text and "30.50" in text
    assert main(["inspect", str(path), "--scenario", "Quite"]) == 1
    assert "did you mean 'Quiet'?" in capsys.readouterr().err
    path.write_text("model nowhere\nego = Car at 0 @ 0\nother = Car ahead of ego by 1\n")
    assert main(["inspect", str(path), "-m", "town", "--show", "scenes"]) == 0
    assert "Car" in capsys.readouterr().out
    assert main(["inspect", str(path), "-p", "lanes"]) == 2
    assert capsys.readouterr().err == "regista: --param must be name=value, got 'lanes'\n"


def test_what_a_program_prints_goes_to_stderr(street, capsys):
    street.write_text(STREET + "print('a street of', 40)\n")
    assert main(["inspect", str(street)]) == 0
    output = capsys.readouterr()
    assert "street.scenic prints: a street of 40\n" in output.err and "prints:" not in output.out


def test_values_of_parameters_are_read_as_python_writes_them():
    texts = ["a=3", "b=-0.5", "c=True", "d=None", "e=[1, 'x']", "f=snow storm", "g="]
    assert read_params(texts) == {"a": 3, "b": -0.5, "c": True, "d": None, "e": [1, "x"], "f": "snow storm", "g": ""}


@pytest.mark.slow
def test_drawn_levels_have_their_values_and_a_legend(tmp_path, monkeypatch):
    from regista.experiments.pictures import plots

    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, path: drawn.append(figure))
    assert main(["inspect", "maze", "--n", "2", "--png", str(tmp_path / "mazes.png")]) == 0
    (figure,) = drawn
    assert [text.get_text() for text in figure.legends[0].texts] == ["seen cells", "goal", "agent"]
    titles = [axes.get_title(loc="left").splitlines() for axes in figure.axes]
    assert [lines[0] for lines in titles] == ["level 0", "level 1"]
    assert all("shortest path" in " ".join(lines) and 2 < len(lines) <= 4 for lines in titles)
    figure.canvas.draw()
    assert all(side.get_visible() for axes in figure.axes for side in axes.spines.values())  # white frames have an edge
    boxes = [axes._left_title.get_window_extent() for axes in figure.axes]
    assert boxes[0].x1 < boxes[1].x0


def test_a_legend_names_the_markers_that_are_drawn(tmp_path, monkeypatch):
    from regista.experiments.pictures import plots

    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, path: drawn.append(figure))
    assert main(["inspect", "1v1Free", "--n", "1", "--png", str(tmp_path / "scenes.png")]) == 0
    said = [text.get_text() for text in drawn[0].legends[0].texts]
    assert said == ["left team", "right keeper", "ball", "heading"]  # the left keeper is outside


@pytest.mark.slow
def test_pictures_and_recordings_of_both_kinds_are_written(street, tmp_path, capsys):
    for program in (str(street), "1v1Free"):
        png, rrd = tmp_path / "scenes.png", tmp_path / "scenes.rrd"
        assert main(["inspect", program, "--n", "2", "--png", str(png), "--rrd", str(rrd)]) == 0
        assert png.read_bytes()[:4] == b"\x89PNG" and rrd.read_bytes()[:3] == b"RRF"
        assert "2 scenes recorded in" in capsys.readouterr().out


def test_a_picture_of_another_ending_is_refused(street, tmp_path, capsys):
    assert main(["inspect", str(street), "--n", "1", "--png", str(tmp_path / "a.jpg")]) == 2
    captured = capsys.readouterr()
    assert "regista: a.jpg: the name of a picture must end in .png or .svg or .pdf" in captured.err
    assert captured.out == "" and not [*tmp_path.glob("a.*")]


@pytest.mark.slow
@pytest.mark.drawn
def test_a_picture_has_the_format_that_is_asked_for(street, tmp_path, capsys):
    assert main(["inspect", str(street), "--n", "1", "--png", str(tmp_path / "scenes.png"), "--format", "svg"]) == 0
    assert "1 scene drawn to" in capsys.readouterr().out
    assert [path.name for path in tmp_path.glob("scenes.*")] == ["scenes.svg"]
    assert (tmp_path / "scenes.svg").read_bytes().startswith(b"<?xml")
    assert main(["inspect", str(street), "--format", "svg"]) == 2
    assert "--format is of the picture that --png draws" in capsys.readouterr().err


def test_a_recording_holds_every_scene_with_its_objects(street, tmp_path, capsys):
    from rerun.chunk import RrdReader

    rrd = tmp_path / "scenes.rrd"
    assert main(["inspect", str(street), "--n", "3", "--seed", "5", "--rrd", str(rrd)]) == 0
    stream = RrdReader(str(rrd)).stream()
    batches = [chunk.to_record_batch() for chunk in stream.filter(content="/scene/objects")]
    assert sorted(time for batch in batches for time in batch.column("scene").to_pylist()) == [0, 1, 2]
    strips = batches[0].column("LineStrips2D:strips").to_pylist()[0]
    program = load(street)
    scenes = program.instantiate(program.sample(3, np.random.default_rng(5))[0])
    view = view_of(program, np.zeros((1, 5)), football=False)
    np.testing.assert_allclose(np.array(strips[0])[:4], corners(view.boxes(scenes))[0, 0], atol=1e-4)
    cards = [chunk.to_record_batch() for chunk in RrdReader(str(rrd)).stream().filter(content="/card")]
    assert "| ego.heading |" in str(cards[0].to_pylist())


def test_a_theta_of_ones_own_is_drawn(street, tmp_path, capsys):
    png = tmp_path / "scene.png"
    theta = ["-0.5", "0", "0.5", "0.5", "0"]
    assert main(["inspect", str(street), "--theta", *theta, "--show", "scenes", "--png", str(png)]) == 0
    assert "1 scene drawn" in capsys.readouterr().out


@pytest.mark.long
def test_a_program_without_objects_or_draws_is_drawn_too(tmp_path, capsys):
    for number, text in enumerate(("param x = Range(0, 1)\n", "new Object at 1 @ 2, with requireVisible False\n")):
        path = tmp_path / f"{number}.scenic"
        path.write_text(text)
        files = ["--png", str(tmp_path / "scene.png"), "--rrd", str(tmp_path / "scene.rrd")]
        assert main(["inspect", str(path), "--dialect", "3", "--show", "scenes", *files]) == 0
        assert "scene 5: θ = " in capsys.readouterr().out


def test_an_impossible_program_is_reported_not_drawn(tmp_path, capsys):
    path = tmp_path / "impossible.scenic"
    path.write_text("ego = Object at Range(0, 1) @ 0\nrequire ego.position.x > 2\n")
    assert main(["inspect", str(path)]) == 0
    assert "line 2: require ego.position.x > 2" in capsys.readouterr().out
    assert main(["inspect", str(path), "--png", str(tmp_path / "scene.png")]) == 1
    assert "no valid scene" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flags", "code", "message"),
    [
        (["--theta", "0", "0"], 2, "--theta takes 5 numbers in [-1, 1]"),
        (["--theta", "0", "0", "0", "0", "1.5"], 2, "--theta: must be at most 1, got 1.5"),
        (["--theta", "0", "0", "0", "0", "nan"], 2, "'nan' is not a finite number"),
        (["--png", "/nowhere/scenes.png"], 1, "cannot write /nowhere/scenes.png: No such file or directory"),
        (["--rrd", "/nowhere/scenes.rrd"], 1, "cannot write /nowhere/scenes.rrd: No such file or directory"),
        (["--n", "0"], 2, "--n: must be at least 1"),
        (["--n", "101", "--png", "scenes.png"], 2, "--png draws at most 100 scenes, got --n 101"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(street, capsys, flags, code, message):
    assert main(["inspect", str(street), *flags]) == code
    assert message in capsys.readouterr().err


def test_boxes_turn_with_the_heading():
    box = np.array([10.0, 5.0, np.pi / 2, 2.0, 4.0])  # looks along -x
    np.testing.assert_allclose(corners(box)[0], (8, 6), atol=1e-12)


def test_a_stage_without_any_ground_holds_its_objects():
    program = load("ego = Object at Range(5, 9) @ -3")
    view = view_of(program, np.array([[-1.0], [1.0]]), football=False)
    low_x, high_x, low_y, high_y = view.bounds
    assert low_x < 5 and high_x > 9 and low_y < -3 < high_y
    assert view.ground == []


def test_behaviors_are_shown_as_code(tmp_path, capsys):
    program = tmp_path / "walk.scenic"
    program.write_text("behavior Walk():\n    take 'a'\n    take 'b'\nego = Object at 1 @ 2, with behavior Walk()\n")
    assert main(["inspect", str(program), "--show", "code"]) == 0
    text = capsys.readouterr().out
    assert "ego: Walk\n" in text
    assert "walk.scenic:2: take 'a'\n" in text
    assert "take" in text.split("walk.scenic:3")[1]


MATCH = """from football.behaviors import *
behavior Wait(n):
    do HoldPosition() for n steps
    {line}
ego = LeftCM at 0 @ 0, with behavior Wait(50)
ball = Ball ahead of ego by 1
"""


@pytest.mark.parametrize(
    "line, warning",
    [
        ("take Shot()", "a match that comes to this line stops: {}:4:10: name 'Shot' is not defined"),
        ("do Wait(n - 1)", "no match can be played: {}:4:5: Wait calls itself"),
    ],
)
def test_a_match_that_cannot_be_played_to_its_end_is_warned_of(tmp_path, capsys, line, warning):
    program = tmp_path / "match.scenic"
    program.write_text(MATCH.format(line=line))
    assert main(["inspect", str(program)]) == 0
    assert f"warning: {warning}".format(program.name) in capsys.readouterr().err


@pytest.mark.parametrize(
    "text, warning",
    [
        ("ego = LeftCM at 0 @ 0\nLeftGK", "a match needs a Ball"),
        (MATCH.format(line="wait") + "param game_duration = -3", "{}:7:7: param game_duration"),
    ],
)
def test_what_is_no_match_is_warned_of(tmp_path, capsys, text, warning):
    program = tmp_path / "match.scenic"
    program.write_text(text)
    assert main(["inspect", str(program)]) == 0
    said = capsys.readouterr().err
    assert "warning: no match can be played: " in said and warning.format(program.name) in said


def test_the_tests_of_a_task_are_checked(tmp_path, capsys):
    path = tmp_path / "odd.py"
    path.write_text(
        "import gymnasium, ued\n"
        "make = lambda n: ued.GymUPOMDP(lambda: gymnasium.make('CartPole-v1'), print, {'force': (1, 2)}, n)\n"
        "odd = ued.Task(make, tests={'strong': {'farce': 2.0}})\n"
    )
    assert main(["inspect", f"{path}:odd"]) == 1
    assert "the levels of the test 'strong' do not match" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["inspect"], ["play", "--scene", "strong"]])
def test_a_test_outside_the_declared_range_names_the_task_as_typed_and_shows_no_levels(
    command, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "range.py").write_text(
        "import gymnasium, ued\n"
        "make = lambda n: ued.GymUPOMDP(lambda: gymnasium.make('CartPole-v1'), print, {'force': (1, 2)}, n)\n"
        "docking = ued.Task(make, tests={'strong': {'force': 3.0}})\n"
    )
    assert main([command[0], "bad/range.py:docking", *command[1:]]) == 1
    shown = capsys.readouterr()
    assert "the levels of the test 'strong' do not match bad/range.py:docking: " in shown.err
    assert "force must be a value of Range(low=1.0, high=2.0), got 3.0" in shown.err and "level 0" not in shown.out


@pytest.mark.parametrize("check", ["", ", valid=lambda level: level['force'] < 1.5"])
def test_the_share_of_valid_levels_is_that_of_a_declared_check(check, tmp_path, capsys):
    path = tmp_path / f"task{len(check)}.py"
    path.write_text(
        "import gymnasium, ued\n"
        f"make = lambda n: ued.GymUPOMDP(lambda: gymnasium.make('CartPole-v1'), print, {{'force': (1, 2)}}, n{check})\n"
    )
    assert main(["inspect", f"{path}:make"]) == 0
    assert ("of random θ pass the check of the task, `valid`" in capsys.readouterr().out) == bool(check)
