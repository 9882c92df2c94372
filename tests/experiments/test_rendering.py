"""What `render` returns is shown as it is, or refused by a sentence that says what was found."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from regista.experiments.__main__ import main
from regista.experiments.run.errors import CommandError
from regista.experiments.run.rendering import fitted, picture
from tests.experiments.test_play_level import TASK

RENDERED = "np.full((16, 16, 3), int(255 * self.walls[0]), np.uint8)"  # of the task of test_play_level
BAD = {
    "raise RuntimeError('no screen')": "the environment cannot render: RuntimeError: no screen",
    "return None": "the environment's render() returned None; for",
    "return [np.zeros((8, 8, 3), np.uint8)] * 2": "returned an array of shape [2, 8, 8, 3]",
    "return [np.zeros((8, 8, 3), np.uint8), np.zeros((9, 8, 3), np.uint8)]": "returned a list",
    "return np.full((8, 8, 3), 0.5)": "returned float64 values from 0.5 to 0.5",
    "return np.full((8, 8, 3), 300)": "returned int64 values from 300 to 300",
    "return 'a picture'": "returned a str",
    "return np.zeros((8, 8, 5), np.uint8)": "returned an array of shape [8, 8, 5]",
}


def task(folder, render):
    assert TASK.count(f"return {RENDERED}") == 1
    (folder / "caves.py").write_text(TASK.replace(f"return {RENDERED}", render))
    return f"{folder / 'caves.py'}:caves"


@pytest.mark.parametrize("render", BAD)
def test_what_is_no_picture_is_said(tmp_path, capsys, render):
    cave = task(tmp_path, render)
    for words in (
        ["play", cave, "--video", str(tmp_path / "a.gif")],
        ["inspect", cave, "--png", str(tmp_path / "a.png")],
    ):
        assert main(words) == 1
        assert BAD[render] in capsys.readouterr().err
    assert sorted(path.suffix for path in tmp_path.iterdir() if path.is_file()) == [".py"]


def test_gray_pictures_and_those_with_an_alpha_channel_are_shown():
    color = np.arange(4 * 5 * 4, dtype=np.uint8).reshape(4, 5, 4)
    assert (picture(color) == color[..., :3]).all()
    for gray in (color[..., 0], color[..., :1], color[..., 0].astype(np.int64)):
        assert picture(gray).dtype == np.uint8 and (picture(gray) == color[..., :1].repeat(3, 2)).all()
    with pytest.raises(CommandError, match="returned None"):
        picture(None)


@pytest.mark.slow
def test_episodes_of_different_size_are_one_film(tmp_path):
    cave = task(
        tmp_path, "return np.full((8 + int(8 * self.walls[0]), 16 + 2 * int(8 * self.walls[0]), 4), 200, np.uint8)"
    )
    assert main(["play", cave, "--episodes", "6", "--video", str(tmp_path / "a.webp")]) == 0
    with Image.open(tmp_path / "a.webp") as film:
        assert film.n_frames >= 1 and film.width == 2 * film.height
    words = ["--total-env-steps", "256", "--num-envs", "2", "--num-steps", "16", "--eval-every", "0"]
    assert main(["train", cave, "--method", "plr", *words, "--out", str(tmp_path / "run")]) == 0
    assert (tmp_path / "run" / "curriculum.rrd").stat().st_size > 0


def test_a_picture_is_fitted_into_a_film():
    small, large = np.full((4, 4, 3), 9, np.uint8), np.full((8, 16, 3), 7, np.uint8)
    page = fitted(small, large)
    assert page.shape == large.shape and (page[2:6, 6:10] == 9).all() and (page[:2] == 128).all()
    page = fitted(large, small)
    assert page.shape == small.shape and (page[1] == 7).all() and (page[0] == 128).all()
