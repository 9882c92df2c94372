"""Tests of the pictures of recordings in the documentation: RGB, with all colors of their legends."""

import numpy as np
import pytest
from PIL import Image

from tests.pages import ROOT
from ued.recorder.shades import SCENE_COLORS, SOURCE_COLORS, STUDENT_COLORS

FOLDER = ROOT / "docs" / "pictures" / "recording"
PICTURES = sorted(FOLDER.glob("*.png"))
LEGENDS = {
    "paired-overview": [*STUDENT_COLORS[:2], *SCENE_COLORS[:3]],
    "plr-overview": [STUDENT_COLORS[0], *SCENE_COLORS[:3]],
    "accel-overview": [STUDENT_COLORS[0], *SCENE_COLORS[:3]],
    "paired-teacher": [SOURCE_COLORS["random"], SOURCE_COLORS["proposed"]],
    "plr-teacher": [SOURCE_COLORS["random"], SOURCE_COLORS["replayed"]],
    "accel-teacher": [SOURCE_COLORS["replayed"], SOURCE_COLORS["edited"]],
}


@pytest.mark.parametrize("path", PICTURES, ids=lambda path: path.stem)
def test_a_picture_is_rgb(path):
    with Image.open(path) as picture:
        assert picture.mode == "RGB"


@pytest.mark.long
@pytest.mark.parametrize("name", LEGENDS)
def test_the_colors_of_its_legend_occur_in_a_picture(name):
    with Image.open(FOLDER / f"{name}.png") as picture:
        pixels = np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0).astype(int)
    for color in LEGENDS[name]:
        assert np.abs(pixels - color).max(1).min() <= 6, f"{color} is missing in {name}.png"
