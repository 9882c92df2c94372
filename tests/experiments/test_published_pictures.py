"""Published pictures have the colors of the methods that they show, so that none has an older palette."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from regista.experiments.pictures import plots
from regista.experiments.pictures.variants import looks
from tests.pages import ROOT

HALF, DENNIS = ("half", "dr"), ("Dennis", "paired")
PICTURES = {  # methods, and variants with their methods in the order in which they get their looks
    "docs/pictures/maze_curves.png": (
        ("dr", "plr", "robust_plr", "accel", "sfl"),
        (("steps", "paired"), ("direct", "paired")),
    ),
    "experiments/gallery/rare_levels.png": (("dr", "paired", "plr"), (("even", "dr"), ("entropy", "paired"))),
    "experiments/gallery/frontier.png": (
        ("dr", "minimax", "paired", "paired_literal", "self_regret", "repaired", "plr", "robust_plr", "accel"),
        (),
    ),
    "docs/pictures/scale.png": (("dr", "plr", "accel", "paired"), ()),
    "experiments/gallery/curricula.png": (("dr", "paired", "robust_plr", "accel", "sfl"), ()),
    "experiments/gallery/overview.png": (("dr",), (("paired_direct", "paired"),)),
    "experiments/gallery/figure_4_4.png": (("built-in",), ()),
    "experiments/gallery/figure_4_9.png": (("dr", "paired", "paired_literal"), (DENNIS,)),
} | {f"experiments/gallery/figure_4_{k}.png": (("dr", "paired", "paired_literal"), (HALF, DENNIS)) for k in range(5, 9)}


@pytest.mark.long
@pytest.mark.parametrize("name", PICTURES)
def test_a_published_picture_has_the_colors_of_its_methods(name):
    methods, variants = PICTURES[name]
    shades = [plots.METHOD_COLORS[method] for method in methods]
    shades += [look.color for look in looks(dict(variants), plots.METHOD_COLORS).values()]
    with Image.open(ROOT / name) as picture:
        pixels = np.asarray(picture.convert("RGB")).reshape(-1, 3)
    colors, counts = np.unique(pixels, axis=0, return_counts=True)
    for shade in shades:
        near = np.abs(colors - 255 * np.array(to_rgb(shade))).max(1) < 1
        assert counts[near].sum() > 50, f"{shade} is missing in {name}"
