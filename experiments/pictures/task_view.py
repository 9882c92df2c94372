"""A Python task as text and as a picture: its parameters, its levels, and their rendered first frames.

Read next: `commands.inspect`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from regista.experiments.run.errors import CommandError
from regista.experiments.run.rendering import rendered
from regista.experiments.run.results import align
from ued.core.painter import Color
from ued.core.upomdp import UPOMDP

Marker = tuple[str, Color, float]  # name, color, radius

DRAWS = 1024  # samples for estimating the share of valid levels
MOST_COLUMNS = 40  # maximum number of listed columns of θ
MOST_OF_A_CHOICE = 60  # maximum number of characters for the values of a choice
MOST_LETTERS = 300  # maximum number of characters for the description of a level
FRAME_WIDTH, TITLE_HEIGHT = 3.0, 0.62  # inches
TITLE_LETTERS, TITLE_LINES = 50, 3  # characters and lines of the values above a frame
CANNOT_DRAW = (
    'cannot draw: make the environments with render_mode="rgb_array"; an environment of your own sets self.render_mode '
    "and has render(), which returns a frame [height, width, 3] of bytes"
)
TITLE: dict[str, Any] = {"fontsize": 7.5, "fontweight": "normal"}


def describe_task(name: str, upomdp: UPOMDP, theta: np.ndarray) -> str:
    """Describe the columns of θ, the spaces, the levels θ `[n, D]`, and the share of valid θ if there is a check."""
    family = "" if upomdp.level_family is None else f", codes of levels of {type(upomdp.level_family).__name__}"
    parts = [f"{name}: D = {upomdp.theta_dim} free parameter{'s' * (upomdp.theta_dim != 1)}{family}"]
    if upomdp.parameters and upomdp.level_family is None:
        rows = [["θ", "name", "kind", "from", "to"]]
        for index, draw in enumerate(upomdp.parameters[:MOST_COLUMNS]):
            kind: Any = getattr(draw, "kind", "")
            told = kind if isinstance(kind, str) else type(kind).__name__
            values = getattr(kind, "values", None)
            ends = (f"{draw.low:g}", f"{draw.high:g}") if values is None else (_listed(values), "")
            rows.append([str(index), draw.name, told, *ends])
        parts.append(align(rows))
        if upomdp.may_reject:
            drawn = np.random.default_rng(0).uniform(-1, 1, (DRAWS, upomdp.theta_dim))
            parts.append(f"{upomdp.valid(drawn).mean():.0%} of random θ pass the check of the task, `valid`")
    parts.append(f"observations: {upomdp.single_observation_space}\nactions: {upomdp.single_action_space}")
    for index, values in enumerate(upomdp.describe(theta)):
        text = ", ".join(f"{key} = {_short(value)}" for key, value in values.items())
        parts.append(f"level {index}: {text[:MOST_LETTERS]}" + " …" * (len(text) > MOST_LETTERS))
    return "\n\n".join(parts)


def draw_task(upomdp: UPOMDP, theta: np.ndarray, path: Path, markers: Sequence[Marker] = ()) -> None:
    """Draw the first frames of the levels θ `[n, D]`, one environment for each, below the values of the level.

    A legend lists those `markers` whose colors occur in every frame. Raises `CommandError` if the environments cannot
    render.
    """
    import matplotlib.pyplot as plt

    from regista.experiments.pictures import plots

    upomdp.reset(seed=0, options={"theta": theta})
    frames = rendered(upomdp)
    if frames is None:
        raise CommandError(CANNOT_DRAW)
    columns = min(len(frames), 4)
    lines = -(-len(frames) // columns)
    tall = FRAME_WIDTH * frames[0].shape[0] / frames[0].shape[1] + TITLE_HEIGHT
    with plots.style():
        size = (FRAME_WIDTH * columns, tall * lines)
        figure, grid = plt.subplots(lines, columns, figsize=size, squeeze=False, layout="constrained")
        for index, (axes, frame, values) in enumerate(zip(grid.flat, frames, upomdp.describe(theta), strict=False)):
            axes.imshow(frame)
            axes.set_title(level_title(index, values), **TITLE)
            axes.set(xticks=[], yticks=[])
            axes.spines[:].set_visible(True)  # borders separate white frames
        for axes in grid.flat[len(frames) :]:
            axes.set_axis_off()
        if handles := _handles(markers, frames):
            figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
        plots.save(figure, path)


def level_title(index: int, values: Mapping[str, Any]) -> str:
    """Return the heading of a drawn level: its number, and as many of its values as fit."""
    text = ", ".join(f"{key} = {_short(value)}" for key, value in values.items())
    lines = textwrap.wrap(text, TITLE_LETTERS, max_lines=TITLE_LINES, placeholder=" …")
    return "\n".join([f"level {index}", *lines])


def _handles(markers: Sequence[Marker], frames: Sequence[np.ndarray]) -> list[Any]:
    """Return the handles of a legend: the markers whose colors are in every frame."""
    from matplotlib.patches import Patch

    kept = [row for row in markers if all((frame[..., :3] == row[1]).all(-1).any() for frame in frames)]
    return [Patch(color=tuple(np.array(shade) / 255), label=name) for name, shade, _ in kept]


def _listed(values: Sequence[Any]) -> str:
    text = ", ".join(_short(value) for value in values)
    return text if len(text) <= MOST_OF_A_CHOICE else f"{text[:MOST_OF_A_CHOICE]} …"


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else " ".join(str(value).split())
