"""A Python task as text and as a picture: its parameters, its levels, and their rendered first frames.

Read next: `commands.inspect`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from regista.experiments.run.errors import CommandError
from regista.experiments.run.results import align
from ued.core.upomdp import UPOMDP

DRAWS = 1024  # samples for the share of valid levels
MOST_COLUMNS = 40  # listed columns of θ
MOST_OF_A_CHOICE = 60  # characters for the values of a choice
MOST_LETTERS = 300  # characters for the description of a level


def describe_task(name: str, upomdp: UPOMDP, theta: np.ndarray) -> str:
    """Describe the columns of θ, the spaces, the share of valid θ, and the levels θ `[n, D]`."""
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
        drawn = np.random.default_rng(0).uniform(-1, 1, (DRAWS, upomdp.theta_dim))
        parts.append(f"{upomdp.valid(drawn).mean():.0%} of random θ are valid levels")
    parts.append(f"observations: {upomdp.single_observation_space}\nactions: {upomdp.single_action_space}")
    for index, values in enumerate(upomdp.describe(theta)):
        text = ", ".join(f"{key} = {_short(value)}" for key, value in values.items())
        parts.append(f"level {index}: {text[:MOST_LETTERS]}" + " …" * (len(text) > MOST_LETTERS))
    return "\n\n".join(parts)


def draw_task(upomdp: UPOMDP, theta: np.ndarray, path: Path) -> None:
    """Draw the first frames of the levels θ `[n, D]`, one environment for each.

    Raises `CommandError` if the environments cannot render.
    """
    import matplotlib.pyplot as plt

    from regista.experiments.pictures import plots

    upomdp.reset(seed=0, options={"theta": theta})
    try:
        frames = upomdp.render() if upomdp.render_mode == "rgb_array" else None
    except Exception as error:  # any error of the environment
        raise CommandError(f"the environment cannot render: {type(error).__name__}: {error}") from error
    if frames is None:
        raise CommandError('cannot draw: make the environments with render_mode="rgb_array"')
    columns = min(len(frames), 4)
    with plots.style():
        lines = -(-len(frames) // columns)
        figure, grid = plt.subplots(lines, columns, figsize=(3 * columns, 3 * lines), squeeze=False)
        for axes, frame in zip(grid.flat, frames, strict=False):
            axes.imshow(frame)
        for axes in grid.flat:
            axes.set_axis_off()
        figure.tight_layout()
        plots.save(figure, path)


def _listed(values: Sequence[Any]) -> str:
    text = ", ".join(_short(value) for value in values)
    return text if len(text) <= MOST_OF_A_CHOICE else f"{text[:MOST_OF_A_CHOICE]} …"


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else " ".join(str(value).split())
