"""replays.csv has the very episodes of a run, and the gallery shows them."""

import base64
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from regista.experiments.__main__ import main
from regista.experiments.pictures import gallery
from regista.experiments.run import build, watch
from regista.experiments.run.errors import CommandError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.level_table import read_levels
from regista.experiments.run.replays import Replay, Stage, came_out_alike
from regista.experiments.run.table import read_header, read_rows
from regista.experiments.run.tasks import CheckedPainter
from tests.experiments.test_files import documented
from ued.core.painter import line_color_of

pytestmark = pytest.mark.slow

TASK = """
import numpy as np
import ued
from ued.probes import Frontier

class Ground:
    bounds = reach = (0.0, 4.0, 0.0, 2.0)
    background, line_color = (20, 20, 20), (200, 200, 200)
    markers, classes, focus = [("walker", (255, 0, 0), 0.2)], np.array([0]), 0

    def lines(self):
        return [np.array([[0.0, 0.0], [4.0, 0.0]])]

    def positions(self, theta):
        return np.stack([theta[:, :1] + 1, theta[:, 1:2] + 1], -1)

    def frame(self, env):
        return np.array([[float(env.place[0]), 1.0]])

def make(num_envs):
    return Frontier(num_envs, longest=4)

task = ued.Task(make, painter=lambda upomdp: Ground())
"""
SHORT = ["--num-envs", "8", "--num-steps", "32", "--hidden-size", "8", "--eval-every", "0", "--record-rollouts", "2"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    (folder / "walk_task.py").write_text(TASK)
    command = ["train", f"{folder}/walk_task.py:task", "--method", "paired", "--total-env-steps", "4_000", *SHORT]
    assert main([*command, "--out", str(folder / "run")]) == 0
    return RunFolder.open(folder / "run")


def stage_of(run):
    task = build.find_game(run.config.minigame).task(run.config)
    env = build.make_upomdp(task.make, 1, 0)
    return Stage(env, task.painter(env))


def levels_of(run):
    """Return the rows of the levels of a run by the number of the visit, as replays.csv spells it."""
    columns = read_levels(run.path)
    rows = [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
    return {str(int(row["visit"])): row for row in rows}


def data_of(page):
    return json.loads(re.search(r"^const data = (.*);$", page.read_text(), re.M)[1])


@pytest.mark.parametrize("size", [0.02, 4.0, 5e4])
def test_positions_are_kept_whatever_the_size_of_the_world(size):
    class World:
        bounds, reach = (-size, size, 0.0, size), (-size, 1.5 * size, 0.0, size)

    unit = gallery._unit(World())
    places = np.random.default_rng(0).uniform(-size, 1.5 * size, (50, 3, 2))
    places[7, 1] = np.nan
    packed = np.frombuffer(base64.b64decode(gallery._pack(places, unit)), "<i2").reshape(places.shape)
    assert (packed[7, 1] == gallery.NOWHERE).all()
    assert np.nanmax(np.abs(np.where(packed == gallery.NOWHERE, np.nan, packed * unit) - places)) < size / 10_000


@pytest.mark.long
def test_every_row_plays_the_very_episodes_again(run):
    stage, rows = stage_of(run), read_rows(run.replays.path)
    assert documented()["replays.csv"] == read_header(run.replays.path)
    assert len(rows) > 40 and {row["student"] for row in rows} == {"protagonist", "antagonist"}
    told = levels_of(run)
    for row in rows:
        replay = Replay.of_row(row, stage.env)
        assert {name: str(value) for name, value in replay.row().items()} == row
        frames, begins, returns = stage.play(replay)
        assert came_out_alike(replay, returns) and 2 * len(returns) <= len(frames) <= len(replay.actions) + len(begins)
        assert begins[0] == 0 and len(begins) == len(returns) and all(frames[k][0, 0] == 0 for k in begins)
        level = told[row["visit"]]
        assert abs(level[f"return/{row['student']}"] - returns.mean()) < 1e-4
        assert replay.level["seed"][0] == level["seed"]


@pytest.mark.long
def test_a_level_that_is_replayed_at_the_same_time_is_told_apart(run, tmp_path):
    task = Path(run.path).parent / "walk_task.py"
    command = ["train", f"{task}:task", "--method", "plr", "--plr.buffer.capacity", "5", "--total-env-steps", "4_000"]
    assert main([*command, *SHORT, "--out", str(tmp_path / "run")]) == 0
    replayed = RunFolder.open(tmp_path / "run")
    rows, stage = read_rows(replayed.replays.path), stage_of(replayed)
    same = [(row["update"], row["id"]) for row in rows]
    assert len(same) - len(set(same)) > 10  # one level, several times in an update
    for row in rows:
        replay = Replay.of_row(row, stage.env)
        assert came_out_alike(replay, stage.play(replay).returns)


def test_the_levels_of_the_highest_scores_are_kept(run):
    rows, levels = read_rows(run.replays.path), levels_of(run)
    for update in {row["update"] for row in rows}:
        kept = {row["visit"] for row in rows if row["update"] == update}
        scores = {visit: row["score"] for visit, row in levels.items() if row["update"] == int(update)}
        assert len(kept) == min(6, len(scores))
        assert min(scores[level] for level in kept) >= max([s for k, s in scores.items() if k not in kept], default=-9)


def test_an_older_painter_keeps_the_name_of_its_lines(run):
    class Older:
        bounds = reach = (0.0, 1.0, 0.0, 1.0)
        background, line_colour, markers, classes, focus = (0, 0, 0), (1, 2, 3), [], np.zeros(0, int), 0

    painter = CheckedPainter(lambda upomdp: Older(), stage_of(run).env)
    assert line_color_of(painter) == line_color_of(Older()) == (1, 2, 3)


def test_long_replays_show_their_progress(run, capsys, monkeypatch):
    monkeypatch.setattr(watch, "PATIENCE_SECONDS", 0.0)
    assert main(["evaluate", str(run.path), "--gallery", "--gallery-replays", "2"]) == 0
    told = capsys.readouterr().err
    assert re.search(r"\d+%  \d+ replays?", told) and re.search(r"^\d+ replays, \d+ s$", told, re.M)


def test_the_page_shows_levels_cards_scenes_and_replays(run, capsys):
    page = run.path / "gallery.html"
    flags = ["--gallery-levels", "20", "--gallery-replays", "7"]
    assert main(["evaluate", str(run.path), "--gallery", *flags]) == 0
    assert "7 with replays" in capsys.readouterr().out
    data, levels = data_of(page), levels_of(run)
    shown = data["levels"]
    assert 20 <= len(shown["id"]) <= 27 and len(data["replays"]) == 7
    for index, visit in enumerate(shown["visit"]):
        row = levels[str(int(visit))]
        assert shown["source"][index] == row["source"] and abs(shown["score"][index] - row["score"]) < 1e-4
    for key, students in data["replays"].items():
        assert key in levels and set(students) == {"protagonist", "antagonist"}
        assert all(each["alike"] and each["frames"] > 1 for each in students.values())
    assert "http" not in page.read_text()  # it needs no network


def test_without_a_painter_it_shows_what_is_rendered_or_words(tmp_path, capsys):
    (tmp_path / "bare_task.py").write_text(TASK)
    command = ["train", f"{tmp_path}/bare_task.py:make", "--method", "plr", "--total-env-steps", "1_000", *SHORT]
    assert main([*command, "--out", str(tmp_path / "run")]) == 0
    assert main(["evaluate", "--gallery", str(tmp_path / "run")]) == 0
    data = data_of(tmp_path / "run" / "gallery.html")
    assert data["scene"] is None and all(each["film"] == [] for each in next(iter(data["replays"].values())).values())


@pytest.mark.parametrize("spoil", ["level", "actions", "returns", "id"])
def test_damaged_rows_are_refused(run, spoil):
    row = read_rows(run.replays.path)[0]
    bad = {"level": "eJz", "actions": "####", "returns": "one", "id": "x"}[spoil]
    with pytest.raises(CommandError, match=r"replays\.csv is damaged"):
        Replay.of_row(row | {spoil: bad}, stage_of(run).env)


def test_a_row_that_unpacks_to_a_gigabyte_is_refused(run):
    import base64
    import zlib

    bomb = base64.b64encode(zlib.compress(bytes(50_000_000))).decode()
    with pytest.raises(CommandError, match="holds more than"):
        Replay.of_row(read_rows(run.replays.path)[0] | {"actions": bomb}, stage_of(run).env)


def test_a_run_of_an_older_version_is_refused(run, tmp_path, capsys):
    old = tmp_path / "old"
    shutil.copytree(run.path, old, ignore=shutil.ignore_patterns("gallery.html"))
    lines = (old / "levels.csv").read_text().splitlines()
    assert "visit" not in lines[0] and "parent" not in lines[0]
    more = ["parent", *[""] * (len(lines) - 1)]  # the older table had it, but no number of visits
    (old / "levels.csv").write_text("".join(f"{line},{cell}\n" for line, cell in zip(lines, more, strict=True)))
    assert main(["evaluate", "--gallery", str(old)]) == 1 and "older version" in capsys.readouterr().err
    assert not (old / "gallery.html").exists()


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--gallery", "--csv", "x.csv"], "--csv and --gallery exclude each other"),
        (["--gallery", "--engine", "grf"], "--engine and --gallery exclude each other"),
        (["--gallery-levels", "10"], "--gallery-levels needs --gallery"),
    ],
)
def test_a_page_is_not_an_evaluation(run, flags, message, capsys):
    assert main(["evaluate", str(run.path), *flags]) == 2
    assert message in capsys.readouterr().err


def test_no_run_no_page(tmp_path, capsys):
    assert main(["evaluate", "--gallery", str(tmp_path)]) == 1 and "not a run folder" in capsys.readouterr().err
    assert main(["gallery"]) == 2 and "regista evaluate RUN --gallery" in capsys.readouterr().err


def test_recordings_off_leaves_no_tape(run, tmp_path):
    task = Path(run.path).parent / "walk_task.py"
    command = ["train", f"{task}:task", "--method", "dr", "--total-env-steps", "600", *SHORT, "--no-record"]
    assert main([*command, "--out", str(tmp_path / "run")]) == 0
    assert not (tmp_path / "run" / "replays.csv").exists()
    assert np.isfinite(read_levels(tmp_path / "run", "seed")["seed"]).all()


def test_a_run_without_a_finished_level_has_no_page(run, tmp_path, capsys):
    short = tmp_path / "short"
    shutil.copytree(run.path, short, ignore=shutil.ignore_patterns("gallery.html", "replays.csv"))
    (short / "levels.csv").write_text((run.path / "levels.csv").read_text().splitlines()[0] + "\n")
    assert main(["evaluate", "--gallery", str(short)]) == 1 and "has no level on which" in capsys.readouterr().err
