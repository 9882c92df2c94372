"""Bar charts of goal differences, ours beside published ones, each with its interval. Read next: `studies.page`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from regista.experiments.pictures.plots import save, style

WIDTH = 0.8  # of all bars of a game
LEGEND_COLUMNS = 4


class Bars(NamedTuple):
    """One bar for each game: heights and both ends of the intervals, nan where there is none."""

    label: str
    colour: str
    heights: Sequence[float]
    lows: Sequence[float]
    highs: Sequence[float]


def draw_bars(games: Sequence[str], groups: Sequence[Bars], heading: str, path: Path) -> None:
    """Draw the groups' bars of each game beside each other. Raises `CommandError` if the disk refuses."""
    import matplotlib.pyplot as plt

    middles, width = np.arange(len(games)), WIDTH / len(groups)
    with style():
        wide = 0.12 * len(groups) * len(games)  # an inch or so for eight bars
        figure, axes = plt.subplots(figsize=(max(6.0, 0.62 * len(games) + 1.5, wide), 3.6))
        for number, group in enumerate(groups):
            places = middles + (number + 0.5) * width - WIDTH / 2
            heights = np.asarray(group.heights, float)
            axes.bar(places, heights, width * 0.92, color=group.colour, label=group.label)
            ends = np.abs(np.stack([heights - group.lows, np.asarray(group.highs) - heights]))
            known = np.isfinite(ends).all(0)
            axes.errorbar(places[known], heights[known], ends[:, known], fmt="none", ecolor="#22262b", elinewidth=0.9)
        axes.axhline(0.0, color="#8a9199", linewidth=0.8)
        axes.set_xticks(middles, [game.partition("/")[2] or game for game in games], rotation=38, ha="right")
        axes.set_ylabel("goal difference per episode")
        axes.set_ylim(-1.05, 1.05)  # intervals of two runs may reach farther
        axes.set_title(heading, pad=10 + 16 * -(-len(groups) // LEGEND_COLUMNS))
        axes.grid(axis="x", visible=False)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=LEGEND_COLUMNS, fontsize=8)  # above the bars
        save(figure, path)
