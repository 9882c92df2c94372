"""Pictures and films of a match."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from pitch import position

from regista.envs.football.constants import CM, GK, LEFT, RIGHT
from regista.envs.football.view import picture
from regista.envs.football.view.picture import BORDER, SCALE, SHARPER, draw_match, write_video
from regista.envs.football.view.render import LEFT_COLOR, LEFT_KEEPER_COLOR, RIGHT_COLOR, RIGHT_KEEPER_COLOR

PLAYERS = [(-20.0, 10.0, LEFT, CM), (-50.0, 0.0, LEFT, GK), (20.0, -10.0, RIGHT, CM), (50.0, 0.0, RIGHT, GK)]


def pixel(x, y):
    """Return row and column of a place in meters."""
    return round((36 + BORDER - y) * SCALE / SHARPER) + 34, round((x + 55 + BORDER) * SCALE / SHARPER)


def near(image, x, y, color, reach=9):
    """Return whether the color is to be seen near a place."""
    line, column = pixel(x, y)
    part = image[line - reach : line + reach, column - reach : column + reach].reshape(-1, 3).astype(int)
    return bool((np.abs(part - color).sum(1) < 30).any())


def test_every_player_is_drawn_in_place_and_color():
    image = draw_match(position(PLAYERS, (0.0, 20.0))[0])
    colors = (LEFT_COLOR, LEFT_KEEPER_COLOR, RIGHT_COLOR, RIGHT_KEEPER_COLOR)
    assert image.dtype == np.uint8 and image.shape == (594, 826, 3)
    for (x, y, _, _), color in zip(PLAYERS, colors, strict=True):
        assert near(image, x, y, color)
        assert not near(image, x, y + 5, color)
    assert near(image, 0.0, 20.0, (255, 255, 255), 4)


def test_a_ball_in_the_air_is_drawn_above_its_shadow():
    matches = position(PLAYERS, (0.0, 20.0))
    low = draw_match(matches[0])
    matches["ball"]["z"] = 5.0
    high = draw_match(matches[0])
    assert not near(low, 0.0, 22.7, (255, 255, 255), 4) and near(high, 0.0, 22.7, (255, 255, 255), 4)
    assert not near(high, 0.0, 20.0, (255, 255, 255), 3)


def test_the_bar_tells_the_score_the_mode_and_whom_the_agent_moves():
    matches = position(PLAYERS, (0.0, 20.0))
    before = draw_match(matches[0])
    for field, value in (("score", [1, 0]), ("game_mode", 4), ("step", 300)):
        changed = matches.copy()
        changed[field] = value
        after = draw_match(changed[0])
        assert (after[:34] != before[:34]).any() and (after[34:] == before[34:]).all()
    assert near(before, -20.0, 10.0, (255, 235, 59), 16) and not near(before, -50.0, 0.0, (255, 235, 59), 16)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_a_film_has_a_frame_per_step(tmp_path, suffix):
    matches = position(PLAYERS, (0.0, 20.0))
    frames = []
    for x in (0.0, 10.0, 20.0, 30.0):
        matches["ball"]["x"] = x
        frames.append(draw_match(matches[0]))
    write_video(tmp_path / f"film{suffix}", frames, speed=2.0)
    with Image.open(tmp_path / f"film{suffix}") as film:
        assert film.n_frames == 4 and film.size == (826, 594)
        film.seek(1)
        film.load()
        assert film.info["duration"] == 50


def test_what_is_no_film_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"must end in \.gif, \.webp or \.mp4"):
        write_video(tmp_path / "film.avi", [np.zeros((10, 10, 3), np.uint8)])
    with pytest.raises(ValueError, match="no frame"):
        write_video(tmp_path / "film.gif", [])
    with pytest.raises(ValueError, match="does not exist"):
        write_video(tmp_path / "nowhere" / "film.gif", [np.zeros((10, 10, 3), np.uint8)])


def test_without_the_package_mp4_is_refused_before_anything_is_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(picture, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match=r"pip install 'regista\[video\]'; or choose \.gif"):
        write_video(tmp_path / "film.mp4", (pytest.fail("a frame was drawn") for _ in range(1)))


@pytest.mark.slow
def test_an_mp4_has_a_frame_per_step(tmp_path):
    reader = pytest.importorskip("imageio_ffmpeg")
    frames = [draw_match(position(PLAYERS, (x, 20.0))[0]) for x in (0.0, 10.0, 20.0, 30.0)]
    write_video(tmp_path / "film.mp4", frames, speed=2.0)
    assert reader.count_frames_and_secs(str(tmp_path / "film.mp4")) == (4, pytest.approx(0.2, abs=0.01))


def test_a_film_has_the_colors_of_all_frames_at_the_right_speed(tmp_path):
    frames = [np.full((20, 30, 3), shade, np.uint8) for shade in ((0, 0, 0), (250, 0, 0), (0, 0, 0), (0, 200, 90))] * 3
    write_video(tmp_path / "film.gif", frames, speed=3.0)
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 12
        shown, duration = [], 0
        for number in range(film.n_frames):
            film.seek(number)
            duration += film.info["duration"]
            shown.append(np.asarray(film.convert("RGB"))[0, 0].tolist())
    assert np.allclose(shown, [frame[0, 0] for frame in frames], atol=picture.FAR)
    assert duration == 400  # 12 of 30 frames per second; each alone would be rounded to 30 ms


@pytest.mark.parametrize("suffix", [".gif", ".webp", ".mp4"])
def test_a_film_that_ends_in_an_error_leaves_nothing_behind(tmp_path, suffix):
    if suffix == ".mp4":
        pytest.importorskip("imageio_ffmpeg")

    def frames():
        for shade in (0, 100, 200):
            yield np.full((20, 30, 3), shade, np.uint8)
        raise RuntimeError("the environment has failed")

    path = tmp_path / f"film{suffix}"
    path.write_bytes(b"an older film")
    with pytest.raises(RuntimeError, match="has failed"):
        write_video(path, frames())
    assert [each.name for each in tmp_path.iterdir()] == [path.name] and path.read_bytes() == b"an older film"
