"""Tasks of the toolkit by their short names on the command line: `maze`."""

import csv
import json
import shutil

import numpy as np
import pytest

from regista.envs.maze.painter import CELL
from regista.experiments.__main__ import main
from regista.experiments.run.build import find_game
from regista.experiments.run.built_in import BUILT_IN
from regista.experiments.run.folder import RunFolder
from regista.minigames.suites import MIXTURES

pytestmark = pytest.mark.slow

BRIEF = ["--num-envs", "4", "--num-steps", "32", "--total-env-steps", "256"]
FULL = "regista.envs.maze.task:maze"


@pytest.fixture(autouse=True)
def nobody_has_named_it(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("maze") / "run"
    words = ["train", "maze", *BRIEF, "--method", "accel", "--eval-every", "0", "--record-rollouts", "2"]
    assert main([*words, "--out", str(out)]) == 0
    return out


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_a_short_name_is_the_task_in_every_command():
    for name in BUILT_IN:
        game = find_game(name)
        assert (game.name, game.short) == (BUILT_IN[name].name, name)
        again = find_game(game.name)
        assert (again.name, again.short) == (game.name, name)
        assert game.task(None).about


def test_its_settings_are_the_selected_ones_that_a_flag_overrides(run):
    config = RunFolder.open(run).config
    assert config.minigame == FULL
    assert (config.ppo.gamma, config.ppo.update_epochs, config.ppo.num_minibatches) == (0.995, 1, 8)
    assert (config.ppo.memory, config.accel.buffer.capacity, config.ppo.num_steps) == ("gru", 4000, 32)


@pytest.mark.long
def test_a_run_is_resumed_and_evaluated_without_trust(run, tmp_path, capsys):
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    assert main(["train", "maze", "--resume", str(copy), "--total-env-steps", "384"]) == 0
    assert rows(copy / "metrics.csv")[-1]["env_steps"] == "384"
    capsys.readouterr()
    assert main(["evaluate", str(copy), "--episodes", "2", "--levels", "0", "--held-out", "--no-baselines"]) == 0
    assert "PerfectMazeLarge" in capsys.readouterr().out
    assert main(["evaluate", str(copy), "--episodes", "2", "--levels", "0"]) == 0
    shown = capsys.readouterr().out
    for name in ("SixteenRooms", "PerfectMazeMedium", "shortest path", "random", "solved"):
        assert name in shown


def test_a_recording_and_a_gallery_show_mazes(run, capsys):
    assert (run / "curriculum.rrd").stat().st_size > 10_000
    assert main(["evaluate", str(run), "--gallery"]) == 0
    page = (run / "gallery.html").read_text()
    begin = page.index('"tiles"')
    tiles = json.loads(page[page.index("[", begin) : page.index("]", begin) + 1])
    assert sum(tiles) == 13 * 13


@pytest.mark.long
@pytest.mark.parametrize("columns", [80, 100])
def test_lines_of_the_list_fit_the_terminal(columns, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(columns))
    assert main(["list"]) == 0
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= columns and "need no training" in " ".join(shown.split())


def test_a_test_whose_label_is_its_name_has_no_description(capsys):
    assert main(["list", "1v1Rare"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["test", "scene", "D"] in lines and ["1v1Rare/easy", "0"] in lines
    assert main(["list", "3v2FourBehaviors"]) == 0
    assert "3v2FourBehaviors/A  0  A: chases the ball" in capsys.readouterr().out


def test_inspect_and_list_say_what_it_is(tmp_path, capsys):
    assert main(["inspect", "maze", "--n", "2", "--png", str(tmp_path / "levels.png")]) == 0
    shown = capsys.readouterr().out
    assert "D = 172" in shown and "shortest path = " in shown and (tmp_path / "levels.png").exists()
    assert main(["list", "maze"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in (FULL, "Labyrinth2", "PerfectMazeLarge", "PLR", "25_000_000"))
    assert main(["list", "ma"]) == 0
    shown = capsys.readouterr().out
    assert all(BUILT_IN[name].about in shown for name in ("maze", "maze60"))
    assert main(["list", "ladder"]) == 0
    head, *games = capsys.readouterr().out.splitlines()
    assert head.startswith("AcademyLadder: a mixture of minigames") and [name.strip() for name in games] == [
        *MIXTURES["AcademyLadder"]
    ]
    assert main(["list", "mazee"]) == 2
    assert "did you mean 'maze' or 'maze60'?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["train", "mase"], "did you mean 'maze' or 'maze60'?"),
        (["train", "maze+1v1Free"], "maze is a Python task"),
        (["play", "maze", "--scene", "Labyrint"], "did you mean 'Labyrinth'?"),
        (["play", "maze", "--player", "nobody"], "idle, shortest path, random, a shipped policy or a run folder"),
        (["play", "maze", "--control", "all"], "omit --control"),
        (["play", "maze", "--engine", "grf"], "a task has its own environments"),
        (["play", "1v1Free", "--scene", "hart"], "did you mean 'hard'?"),
        (["play", "1v1Free", "--player", "runs/x"], "bot, random, idle"),
    ],
)
def test_what_it_is_not_is_said(words, message, capsys):
    assert main(words) == 2
    assert message in capsys.readouterr().err


def test_students_and_baselines_play_its_tests(run, tmp_path, capsys):
    video = tmp_path / "maze.gif"
    words = ["play", "maze", "--scene", "Labyrinth", "--player", "shortest path", "--video", str(video)]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "by the baseline 'shortest path', return 0.7" in shown and "ended" in shown and video.stat().st_size > 0
    assert main(["play", "maze", "--scene", "FourRooms", "--player", str(run), "--seed", "3"]) == 0
    shown = capsys.readouterr().out
    assert "steps by accel after 256 env_steps" in shown
    assert main(["play", "maze", "--scene", "FourRooms", "--player", str(run), "--seed", "3"]) == 0
    assert capsys.readouterr().out == shown
    row = rows(run / "levels.csv")[0]
    assert main(["play", "--level", str(run), "--id", row["id"], "--player", str(run), "--steps", "5"]) == 0
    assert "walls = " in capsys.readouterr().out
    assert main(["play", "ued.probes:frontier", "--player", str(run)]) == 2
    assert "cannot play" in capsys.readouterr().err
    assert main(["play", "ued.probes:frontier", "--scene", "every length", "--player", "idle"]) == 0
    assert "1 step by always the first action" in capsys.readouterr().out


@pytest.mark.long
def test_methods_are_compared_on_mazes(tmp_path, trained_here):
    words = ["compare", "maze", "--methods", "dr", "plr", "robust_plr", "accel", "sfl", "--seeds", "1", *BRIEF]
    more = ["--eval-every", "0", "--no-record", "--episodes", "2", "--levels", "0", "--out", str(tmp_path / "c")]
    assert main([*words, *more]) == 0
    found = rows(tmp_path / "c" / "results.csv")
    assert {row["method"] for row in found} == {"dr", "plr", "robust_plr", "accel", "sfl", "shortest path", "random"}
    best = [row for row in found if row["method"] == "shortest path"]
    assert len(best) == 13 and all(
        row["goals"] == row["episodes"] for row in best if row["scene"] != "training distribution"
    )
    assert {path.name for path in (tmp_path / "c").glob("*.png")} == {
        "overview.png",
        "learning_curves.png",
        "levels.png",
    }


def test_walls_are_recorded_as_squares_and_only_the_agent_leaves_a_path(run):
    from rerun.chunk import RrdReader

    found = {}
    for chunk in RrdReader(str(run / "curriculum.rrd")).stream():
        batch = chunk.to_record_batch()
        if str(chunk.entity_path).startswith("/scene/") and "LineStrips2D:strips" in batch.schema.names:
            found.setdefault(str(chunk.entity_path), []).extend(batch.column("LineStrips2D:strips").to_pylist())
    walls = [strips for strips in found["/scene/levels/0/tiles"] if strips]
    points = np.array(walls[0]).reshape(len(walls[0]), -1, 2) / CELL  # [walls, points of a square, 2] cells
    np.testing.assert_allclose(points.mean(1) % 1, 0.5, atol=1e-5)  # in the middle of cells
    assert 10 < len(points) <= 25 and np.abs(points - points.mean(1, keepdims=True)).max() < 0.5
    paths = [strips for strips in found["/scene/rollout/student/path/lines"] if strips]
    assert len(paths[0]) % 2 == 0 and len(paths[0]) < 40  # goal and agent, of each episode, and no walls
