"""`regista play --player RUN`: a trained student is watched, in football and in a task with pictures of its own."""

import numpy as np
import pytest
from PIL import Image

from regista.envs.football.view import picture
from regista.experiments.__main__ import main
from tests.experiments.test_play_level import SMALL, TASK

STUDENT = "by dr after 1_024 env_steps"


@pytest.fixture(scope="module")
def football(tmp_path_factory):
    run = tmp_path_factory.mktemp("football") / "run"
    assert main(["train", "1v1Free", "--method", "dr", *SMALL, "--out", str(run)]) == 0
    return str(run)


@pytest.fixture(scope="module")
def caves(tmp_path_factory):
    folder = tmp_path_factory.mktemp("filmed")
    text = TASK.replace("ued.Task(make)", "ued.Task(make, tests={'deep': [{'depth': 0.25}, {'depth': 0.75}]})")
    (folder / "filmed.py").write_text(text)
    (folder / "unseen.py").write_text(text.replace('render_mode = "rgb_array"', "render_mode = None"))
    words = ["train", f"{folder / 'filmed.py'}:caves", "--method", "dr", *SMALL, "--out", str(folder / "run")]
    assert main(words) == 0
    return folder


def played(words, capsys):
    capsys.readouterr()
    assert main(["play", *words]) == 0
    return capsys.readouterr().out.splitlines()


@pytest.mark.long
def test_a_student_of_football_is_filmed(football, tmp_path, capsys):
    video = tmp_path / "policy.gif"
    words = ["--player", football, "--steps", "12"]
    shown = played([*words, "--episodes", "2", "--video", str(video)], capsys)
    assert [STUDENT in line for line in shown] == [True, True, False]
    assert shown[-1].startswith("2 episodes: mean return ")
    steps = [int(line.split()[0]) for line in shown[:2]]
    with Image.open(video) as film:
        assert film.n_frames <= sum(steps) + 2 and film.n_frames > max(steps)  # equal frames are joined
    assert played(["1v1Free", *words, "--seed", "1"], capsys) == shown[1:2]  # each episode is that of its seed


@pytest.mark.slow
def test_a_student_plays_test_scenes_levels_and_other_games(football, tmp_path, capsys):
    assert STUDENT in played(["1v1Free", "--scene", "hard", "--player", football, "--greedy"], capsys)[0]
    assert STUDENT in played(["1v1Restricted", "--player", football], capsys)[0]
    record = str(tmp_path / "match.npz")
    before = played(["--level", football, "--id", "1", "--player", football, "--record", record], capsys)
    assert STUDENT in before[1]
    assert "replayed exactly" in played(["--replay", record], capsys)[0]


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["3v2FourBehaviors", "--player", "RUN"], "was trained with observations of shape"),
        (["1v1Free", "--player", "RUN", "--control", "all"], "--control and --player RUN exclude each other"),
        (["1v1Free", "--player", "CAVES"], "it cannot play football"),
        (["1v1Free", "--episodes", "2", "--record", "x.npz"], "--record writes one match"),
        (["1v1Free", "--seed", str(2**32 - 1), "--episodes", "2"], "needs seeds above"),
        (["--player", "nowhere"], "--player RUN, such as shipped:maze, --level RUN --id N"),
    ],
)
def test_what_cannot_be_played_is_said(words, message, football, caves, capsys):
    names = {"RUN": football, "CAVES": str(caves / "run")}
    assert main(["play", *(names.get(word, word) for word in words)]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_a_student_of_a_task_is_filmed_on_each_level_of_a_test(caves, tmp_path, capsys):
    video = tmp_path / "caves.gif"
    words = ["--player", str(caves / "run"), "--scene", "deep", "--episodes", "3", "--video", str(video)]
    shown = played(words, capsys)
    assert [line.rpartition("depth = ")[2] for line in shown[:6:2]] == ["0.25", "0.75", "0.25"]
    assert all(f"4 steps {STUDENT}" in line for line in shown[1:6:2]) and "success" in shown[6]
    ends = [line.rpartition(", ")[2] for line in shown[1:6:2]]
    solved = ends.count("ended with success")
    assert solved + ends.count("ended without success") == 3 and f"success {solved} of 3" in shown[6]
    with Image.open(video) as film:
        assert film.info["duration"] % 100 == 0  # render_fps = 10


@pytest.mark.slow
def test_environments_without_pictures_and_missing_packages_are_named(caves, tmp_path, monkeypatch, capsys):
    assert main(["play", f"{caves / 'unseen.py'}:caves", "--video", str(tmp_path / "x.gif")]) == 2
    assert 'gymnasium.make(..., render_mode="rgb_array")' in capsys.readouterr().err
    monkeypatch.setattr(picture, "find_spec", lambda name: None)
    assert main(["play", "1v1Free", "--video", str(tmp_path / "x.mp4")]) == 2
    assert "pip install 'regista[video]'" in capsys.readouterr().err


def test_a_fast_film_leaves_frames_out(tmp_path):
    ramp = np.repeat(np.arange(0, 240, 8, dtype=np.uint8)[None, :, None], 3, axis=2).repeat(8, axis=0)
    frames = [np.roll(ramp, index, axis=1) for index in range(30)]  # the colors of the first are those of all
    picture.write_video(tmp_path / "fast.gif", iter(frames), speed=15)  # 150 frames per second
    with Image.open(tmp_path / "fast.gif") as film:
        assert film.n_frames == 10 and film.info["duration"] == 20


def test_frames_of_odd_size_are_padded_for_mp4(tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    frames = [np.full((33, 31, 3), 8 * index, np.uint8) for index in range(10)]
    picture.write_video(tmp_path / "odd.mp4", iter(frames), speed=2)
    about = next(ffmpeg.read_frames(tmp_path / "odd.mp4"))
    assert about["size"] == (32, 34) and about["fps"] == 20
